// node validate_gltf.mjs [--modules FOLDER] FILE...
// Runs the Khronos glTF validator on the files and prints a JSON summary. Exit status: 0 no error
// and no warning, 1 some, 2 wrong usage, 3 the package gltf-validator is not installed (npm ci, in
// this folder or in FOLDER).
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const args = process.argv.slice(2);
let base = path.dirname(fileURLToPath(import.meta.url));
if (args[0] === '--modules') {
  base = path.resolve(args[1]);
  args.splice(0, 2);
}

let validator;
try {
  validator = createRequire(path.join(base, 'package.json'))('gltf-validator');
} catch {
  console.error(`gltf-validator is not installed in ${base}`);
  process.exit(3);
}
if (args.length === 0) {
  console.error('usage: node validate_gltf.mjs [--modules FOLDER] FILE...');
  process.exit(2);
}

async function validate(file) {
  const bytes = await readFile(file);
  const report = await validator.validateBytes(new Uint8Array(bytes), {
    uri: path.basename(file),
    maxIssues: 20,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  return {
    file,
    errors: numErrors,
    warnings: numWarnings,
    infos: numInfos,
    hints: numHints,
    messages: messages.map(({ code, message, severity, pointer }) =>
      ({ code, message, severity, pointer })),
  };
}

let failed = false;
const results = [];
for (const file of args) {
  let result;
  try {
    result = await validate(file);
  } catch (error) {
    result = { file, errors: 1, warnings: 0, infos: 0, hints: 0,
               messages: [{ code: 'UNREADABLE', message: String(error) }] };
  }
  failed ||= result.errors + result.warnings > 0;
  results.push(result);
}
console.log(JSON.stringify(results, null, 1));
process.exit(failed ? 1 : 0);
