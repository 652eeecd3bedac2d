// node browser_test.mjs --pointbake PATH [--data FOLDER] [--out FOLDER] [--pictures FOLDER] [--only NAME,...] [--keep]
// Textures as a browser shows them (three.js in headless chromium): each result beside its truth's own GLB, both against
// what the truth should look like; and how much of the debug background shows. docs/browser.md says what is measured.
// --keep uses the models that an earlier run left in --out. Exit status: 0 all within limits, 1 not, 2 wrong usage.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import puppeteer from 'puppeteer-core';
import { glb_of_obj } from './truth_glb.mjs';

const kHere = path.dirname(fileURLToPath(import.meta.url));
const kDistances = Array.from({ length: 5 }, (_, i) => 20 ** (i / 4));  // times the nearest
const kMostWorse = 1;                                                   // of 255, RMS; not when near
const kMostMagenta = 1 / 8;

const kTexels = 1048576;
const kModels = [  // as the quality bench has them
  { name: 'spot', points: 200000, triangles: 10000 },
  { name: 'bob', points: 200000, triangles: 8000 },
  { name: 'clay_tablet', points: 300000, triangles: 10000 },
  { name: 'hope_macaroni_and_cheese', points: 300000, triangles: 4000 },
  { name: 'barramundi_fish', points: 250000, triangles: 6000 },
  { name: 'water_bottle', points: 200000, triangles: 3000 },
  { name: 'tea_set', points: 300000, triangles: 12000 },
  { name: 'corset', points: 300000, triangles: 9000 },
  { name: 'avocado', points: 150000, triangles: 600, mode: 'blue' },
  { name: 'copyroom', points: 300000, triangles: 12000 },
];

function usage(problem) {
  console.error(`${problem}\nusage: node browser_test.mjs --pointbake PATH [--data FOLDER] [--out FOLDER] ` +
                '[--pictures FOLDER] [--only NAME,...] [--keep]');
  process.exit(2);
}

function options_of(words) {
  const options = { out: 'browser-out', data: process.env.POINTBAKE_DATA ?? path.join(kHere, '../../../shared/data') };
  while (words.length > 0) {
    const name = words.shift().replace(/^--/, '');
    if (name === 'keep') options.keep = true;
    else if (!['pointbake', 'data', 'out', 'pictures', 'only'].includes(name)) usage(`unknown: ${name}`);
    else if (words.length === 0) usage(`--${name} needs a value`);
    else options[name] = words.shift();
  }
  if (!options.pointbake) usage('--pointbake is missing');
  return options;
}

const options = options_of(process.argv.slice(2));
const in_out = (name) => path.join(options.out, name);
const pointbake = (...words) => execFileSync(options.pointbake, [...words.map(String), '-q'], { stdio: 'inherit' });

function convert(cloud, name, ...words) {
  pointbake(in_out(cloud), in_out(`${name}.glb`), ...words);
  pointbake(in_out(cloud), in_out(`${name}-debug.glb`), ...words, '--debug-background', 'ff00ff');
}

// The files of a model in --out, made if need be: { truth, result, debug }.
async function make_model(model) {
  const { name } = model;
  const files = { result: `${name}.glb`, debug: `${name}-debug.glb` };
  if (name !== 'demo') files.truth = `${name}-truth.glb`;
  if (options.keep && Object.values(files).every((file) => existsSync(in_out(file)))) return files;
  if (name === 'demo') {
    pointbake('demo', in_out('demo-own.glb'));
    convert('demo-own-points.ply', name);
    return files;
  }
  const obj = path.join(options.data, 'textured', `${name}.obj`);
  writeFileSync(in_out(files.truth), await glb_of_obj(obj));
  pointbake('sample', obj, in_out(`${name}.ply`), '--points', model.points, '--mode', model.mode ?? 'ldc');
  convert(`${name}.ply`, name, '--triangles', model.triangles, '--texels', kTexels);
  return files;
}

// The page, three.js and the models, to this machine alone.
async function serve() {
  const folders = { page: kHere, modules: path.join(kHere, 'node_modules'), models: path.resolve(options.out) };
  const types = { '.html': 'text/html', '.js': 'text/javascript', '.glb': 'model/gltf-binary' };
  const server = http.createServer((request, response) => {
    const [folder, ...rest] = new URL(request.url, 'http://localhost').pathname.split('/').slice(1);
    const file = path.join(folders[folder] ?? kHere, ...rest);  // URL has removed every '..'
    if (!folders[folder] || !existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': types[path.extname(file)] ?? 'application/octet-stream' });
    return response.end(readFileSync(file));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { server, url: `http://127.0.0.1:${server.address().port}` };
}

async function open_page(url) {
  const browser = await puppeteer.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    // WebGL in software, the same on every machine.
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
    protocolTimeout: 0,
  });
  const page = await browser.newPage();
  page.on('console', (message) => {
    // Reading pixels at once is what is wanted here.
    if (!message.text().includes('GPU stall due to ReadPixels')) console.error(`page: ${message.text()}`);
  });
  page.on('pageerror', (error) => console.error(`page: ${error.stack ?? error}`));
  await page.goto(`${url}/page/index.html`);
  await page.waitForFunction('window.is_ready', { timeout: 60000 });
  return { browser, page };
}

const kTableHead = '| model | filter | distance | pixels | truth | result | worse | worst direction | level 0 | moved | ' +
                   'worse where not | magenta | above 1/8 | nearest |';

function line_of(name, row) {
  const cells = [name, row.filter, `${row.times.toFixed(2)}x`];
  if (row.pixels === undefined) cells.push(...Array(8).fill(''));
  else
    cells.push(row.pixels, row.truth.toFixed(2), row.result.toFixed(2), row.worse.toFixed(2), row.worst.by.toFixed(2),
               row.plain.toFixed(2), `${(100 * row.moved).toFixed(0)} %`, row.still_worse.toFixed(2));
  const { share, above, pixels, nearest } = row.magenta;
  cells.push(share.toFixed(3), `${(100 * above / pixels).toFixed(2)} %`, nearest);
  return `| ${cells.join(' | ')} |`;
}

function failures_of(row) {
  const failures = [];
  if (row.pixels === 0) failures.push('truth and result share no pixel');
  if (row.times > 1 && row.worse > kMostWorse) failures.push(`${row.worse.toFixed(2)} worse than its truth`);
  if (row.magenta.nearest < 255 * kMostMagenta) failures.push(`a pixel is ${row.magenta.nearest} steps from magenta`);
  return failures;
}

async function measure_model(page, url, name, files) {
  const urls = Object.fromEntries(Object.entries(files).map(([what, file]) => [what, `${url}/models/${file}`]));
  await page.evaluate((them) => window.open_models(them), urls);
  const failures = [];
  for (const times of kDistances) {
    const rows = await page.evaluate(async (...words) => {
      const rows = window.measure(...words);
      for (const row of rows) if (row.picture) row.picture = await window.as_png(row.picture);
      return rows;
    }, times, kMostMagenta, Boolean(options.pictures));
    for (const row of rows) {
      console.log(line_of(name, row));
      failures.push(...failures_of(row).map((text) => `${name}, ${row.filter}, ${times.toFixed(2)}x: ${text}`));
      if (!row.picture) continue;
      const file = `${name}-${times.toFixed(2)}x-${row.filter.split(' ')[0]}.png`;
      writeFileSync(path.join(options.pictures, file), Buffer.from(row.picture, 'base64'));
    }
  }
  return failures;
}

mkdirSync(options.out, { recursive: true });
if (options.pictures) mkdirSync(options.pictures, { recursive: true });
const wanted = (model) => !options.only || options.only.split(',').includes(model.name);
const models = [{ name: 'demo' }, ...kModels].filter(wanted);
if (models.length === 0) usage(`--only ${options.only}: no such model`);
const { server, url } = await serve();
const { browser, page } = await open_page(url);
const failures = [];
let num_passed = 0, num_failed = 0, num_skipped = 0;
console.log(`${kTableHead}\n${'|---'.repeat(14)}|`);
for (const model of models) {
  if (model.name !== 'demo' && !existsSync(path.join(options.data, 'textured', `${model.name}.obj`))) {
    console.error(`SKIPPED ${model.name}: it is not in ${options.data}/textured; POINTBAKE_DATA names another folder`);
    ++num_skipped;
    continue;
  }
  const found = await measure_model(page, url, model.name, await make_model(model));
  failures.push(...found);
  if (found.length === 0) ++num_passed;
  else ++num_failed;
}
await browser.close();
server.close();
for (const failure of failures) console.log(`FAILED ${failure}`);
console.log(`${num_passed} passed, ${num_failed} failed, ${num_skipped} skipped`);
process.exit(failures.length > 0 ? 1 : 0);
