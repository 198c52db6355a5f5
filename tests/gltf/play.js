// Plays a .glb file with three.js in a browser without a display, and looks at pictures of it at two times.
// usage: node play.js FILE.glb BROWSER OUT_FOLDER
'use strict';
const fs = require('fs');
const http = require('http');
const path = require('path');
const puppeteer = require('puppeteer-core');

const page_text = `<!doctype html><body style="margin:0"><script type="importmap">
{"imports": {"three": "/three/build/three.module.js", "loaders/": "/three/examples/jsm/loaders/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'loaders/GLTFLoader.js';
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(320, 240);
document.body.appendChild(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xffffff);
scene.add(new THREE.HemisphereLight(0xffffff, 0x444444, 3));
const camera = new THREE.PerspectiveCamera(30, 320 / 240, 0.01, 1000);
const gltf = await new GLTFLoader().loadAsync('/file.glb');
scene.add(gltf.scene);
const mixer = new THREE.AnimationMixer(gltf.scene);
const clip = gltf.animations[0];
if (clip)
    mixer.clipAction(clip).play();
// Shows a time of the film: how many meshes are seen, and of how many pixels.
window.show = (seconds, fit) => {
    mixer.setTime(seconds);
    scene.updateMatrixWorld(true);
    let seen = [];
    const box = new THREE.Box3();
    gltf.scene.traverse((o) => {
        if (o.isMesh && o.matrixWorld.determinant() > 0.5) {
            seen.push(o.name);
            box.expandByObject(o);
        }
    });
    if (fit) {
        const middle = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3()).length();
        camera.position.copy(middle).add(new THREE.Vector3(0.3, 0.2, 1).multiplyScalar(1.8 * size));
        camera.lookAt(middle);
    }
    renderer.render(scene, camera);
    const gl = renderer.getContext(), pixels = new Uint8Array(4 * 320 * 240);
    gl.readPixels(0, 0, 320, 240, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let drawn = 0;
    for (let i = 0; i < pixels.length; i += 4)
        drawn += pixels[i] < 250;
    return { seen, drawn, duration: clip ? clip.duration : 0 };
};
window.ready = true;
</script>`;

function serve(file, three) {
    return http.createServer((request, response) => {
        const name = request.url === '/file.glb' ? file : request.url.startsWith('/three/') ?
            path.join(three, path.normalize(request.url.slice('/three/'.length))) : null;
        response.setHeader('Content-Type', !name ? 'text/html' : name.endsWith('.js') ? 'text/javascript' :
            'application/octet-stream');
        if (name)
            fs.createReadStream(name).on('error', () => { response.statusCode = 404; response.end(); }).pipe(response);
        else
            response.end(page_text);
    });
}

function check(ok, what) {
    if (!ok)
        throw new Error(what);
}

async function look(page, folder) {
    const first = await page.evaluate(() => window.show(0, true));
    await page.screenshot({ path: path.join(folder, 'first.png') });
    check(first.seen.length === 1, `at 0 s ${first.seen.length} surfaces are shown: ${first.seen}`);
    check(first.drawn > 1000 && first.drawn < 40000, `at 0 s ${first.drawn} pixels are drawn`);
    const half = await page.evaluate((t) => window.show(t, false), first.duration / 2);
    await page.screenshot({ path: path.join(folder, 'half.png') });
    check(half.seen.length === 1 && half.seen[0] !== first.seen[0], `in the middle is shown: ${half.seen}`);
    check(half.drawn > 500, `in the middle ${half.drawn} pixels are drawn`);
    const pictures = ['first.png', 'half.png'].map((name) => fs.readFileSync(path.join(folder, name)));
    check(!pictures[0].equals(pictures[1]), 'both pictures are the same');
    console.log(`${first.duration} s; ${first.seen[0]}: ${first.drawn} pixels; ${half.seen[0]}: ${half.drawn} pixels`);
}

async function main(file, browser_path, folder) {
    const three = path.dirname(path.dirname(require.resolve('three')));
    const server = serve(path.resolve(file), three).listen(0, '127.0.0.1');
    const browser = await puppeteer.launch({
        executablePath: browser_path,
        args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
    });
    try {
        const page = await browser.newPage(), errors = [];
        page.on('pageerror', (e) => errors.push(String(e)));
        await page.setViewport({ width: 320, height: 240 });
        await page.goto(`http://127.0.0.1:${server.address().port}/`);
        await page.waitForFunction('window.ready', { timeout: 60000 }).catch(() => {
            throw new Error(`the file was not loaded: ${errors}`);
        });
        await look(page, folder);
    } finally {
        await browser.close();
        server.close();
    }
}

main(...process.argv.slice(2)).catch((e) => {
    console.error(`play.js: ${e.message}`);
    process.exit(1);
});
