// The Khronos validator finds no error and no warning in a GLB file.
// Usage: node validate_gltf.cjs VALIDATOR_FOLDER FILE.glb
const fs = require("fs");
const [folder, file] = process.argv.slice(2);
const validator = require(folder);

validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { uri: file }).then((report) => {
    const { numErrors, numWarnings, numInfos, messages } = report.issues;
    for (const m of messages) console.log(`${file}: ${m.code} at ${m.pointer}: ${m.message}`);
    console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} notes`);
    process.exit(numErrors + numWarnings > 0 ? 1 : 0);
}, (error) => {
    console.log(`${file}: ${error}`);
    process.exit(1);
});
