// Compares the frames that nsdf-enc finds in animated .glb files with the poses that three.js finds at the same times.
// usage: node pose.js PRINT_FRAMES FILE.glb...
// PRINT_FRAMES FILE prints a line "frame SECONDS" and then a line "x y z" for each vertex, for every frame.
'use strict';
const { execFileSync } = require('child_process');
const fs = require('fs');
const path = require('path');
const { pathToFileURL } = require('url');

function load(name) {
    return import(pathToFileURL(path.join(process.cwd(), 'node_modules/three', name)).href);
}

// Vertices of all meshes that are not scaled to nothing, in the order of the scene.
function vertices(THREE, scene) {
    const found = [];
    scene.updateMatrixWorld(true);
    scene.traverse((object) => {
        if (!object.isMesh || (!object.isSkinnedMesh && object.matrixWorld.determinant() === 0))
            return;
        if (object.isSkinnedMesh)
            object.skeleton.update();
        for (let i = 0; i < object.geometry.attributes.position.count; i++) {
            const p = new THREE.Vector3();
            object.getVertexPosition(i, p); // with morph targets and bones
            found.push(p.applyMatrix4(object.matrixWorld));
        }
    });
    return found;
}

function run(program, file) {
    return execFileSync(program, [file], { encoding: 'utf8', maxBuffer: 1 << 30 });
}

function frames(text) {
    const all = [];
    for (const line of text.trim().split('\n')) {
        const words = line.split(' ');
        if (words[0] === 'frame')
            all.push({ seconds: Number(words[1]), points: [] });
        else
            all[all.length - 1].points.push(words.map(Number));
    }
    return all;
}

function furthest(ours, theirs) {
    if (ours.length !== theirs.length)
        return Infinity;
    let most = 0;
    ours.forEach((p, i) => {
        most = Math.max(most, Math.hypot(p[0] - theirs[i].x, p[1] - theirs[i].y, p[2] - theirs[i].z));
    });
    return most;
}

async function main(program, files) {
    const THREE = await load('build/three.module.js');
    const { GLTFLoader } = await load('examples/jsm/loaders/GLTFLoader.js');
    let bad = files.length === 0;
    for (const file of files) {
        const bytes = fs.readFileSync(file);
        const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
        const gltf = await new GLTFLoader().parseAsync(buffer, '');
        const first = Math.min(...gltf.animations[0].tracks.map((t) => t.times[0]));
        const mixer = new THREE.AnimationMixer(gltf.scene);
        const action = mixer.clipAction(gltf.animations[0]);
        action.setLoop(THREE.LoopOnce);
        action.clampWhenFinished = true;
        action.play();
        let most = 0, count = 0;
        for (const frame of frames(run(program, file))) {
            mixer.setTime(first + frame.seconds + 1e-6); // behind steps, which float keys may put a little late
            most = Math.max(most, furthest(frame.points, vertices(THREE, gltf.scene)));
            count++;
        }
        console.log(`${file}: ${count} frames, at most ${most.toExponential(1)} apart`);
        bad = bad || count < 2 || !(most < 1e-4);
    }
    process.exit(bad ? 1 : 0);
}

main(process.argv[2], process.argv.slice(3));
