// Checks .glb files with the Khronos validator: no errors, no warnings.
// usage: node validate.js FILE.glb...
'use strict';
const fs = require('fs');
const validator = require('gltf-validator');

async function main(files) {
    let bad = files.length === 0;
    for (const file of files) {
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 20 });
        const { numErrors, numWarnings, messages } = report.issues;
        console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${report.info.drawCallCount} meshes`);
        for (const m of messages)
            console.log(`  ${m.code} at ${m.pointer}: ${m.message}`);
        bad = bad || numErrors + numWarnings > 0;
    }
    process.exit(bad ? 1 : 0);
}

main(process.argv.slice(2));
