// Measures in the page; browser_test.mjs calls what is put on `window` here.
import { dispose, directions, ideal, is_background, kAnisotropy, load, look, shown, sphere_of } from './views.js';

// From afar a picture has few pixels, and eight would leave the figures to chance.
const num_directions = (times) => (times < 8 ? 8 : times < 16 ? 16 : 32);
const kSheetRows = 8;
const kMoved = 1 / 800;    // of the depth range: a pixel that sees another place of the surface
const kMagenta = [1, 0, 1];
const kOwnMagenta = 0.25;  // nearer than this (squared) the model's colour tells no shares apart

const to_linear = Array.from({ length: 256 }, (_, code) =>
  code <= 10 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4);
const to_code = (x) => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);

let truth, result, debug, sphere;

// truth may be missing: then only the debug background can be looked at.
window.open_models = async (urls) => {
  for (const model of [truth, result, debug]) if (model) dispose(model);
  truth = urls.truth ? await load(urls.truth) : undefined;
  result = await load(urls.result);
  debug = await load(urls.debug);
  sphere = sphere_of(truth ?? result);
};

const new_sums = () => ({ pixels: 0, truth: 0, result: 0, plain: 0 });
const rms = (sums, what) => Math.sqrt(sums[what] / (3 * sums.pixels));
const worse = (sums) => rms(sums, 'result') - rms(sums, 'truth');

// Squared differences to the reference, of all pixels and of those where the depth is the same.
function add_errors(views, filter, all, still) {
  const { reference, plain } = views;
  const pictures = { truth: views.truth[filter], result: views.result[filter] };
  for (let p = 0; p < reference.length; p += 4) {
    if (reference[p + 3] === 0 || plain[p + 3] === 0) continue;
    const to = Math.abs(reference[p + 3] - plain[p + 3]) > kMoved ? [all] : [all, still];
    for (const sums of to) ++sums.pixels;
    for (let c = p; c < p + 3; ++c) {
      const code = to_code(reference[c]);
      for (const sums of to) {
        sums.truth += (pictures.truth[c] - code) ** 2;
        sums.result += (pictures.result[c] - code) ** 2;
        sums.plain += (to_code(plain[c]) - code) ** 2;
      }
    }
  }
}

// How much magenta is in a pixel: shown = (1 - a) normal + a magenta in linear light, where mip
// levels mix. And the plain distance, the largest difference of a channel in steps of 255.
function look_for_magenta(normal, shown_debug, most, found) {
  for (let p = 0; p < normal.length; p += 4) {
    let along = 0, length = 0, distance = 0;
    for (let c = 0; c < 3; ++c) {
      const from = to_linear[normal[p + c]];
      along += (to_linear[shown_debug[p + c]] - from) * (kMagenta[c] - from);
      length += (kMagenta[c] - from) ** 2;
      distance = Math.max(distance, Math.abs(shown_debug[p + c] - 255 * kMagenta[c]));
    }
    found.nearest = Math.min(found.nearest, distance);
    if (length <= kOwnMagenta) continue;
    found.share = Math.max(found.share, along / length);
    found.above += along / length >= most ? 1 : 0;
    found.pixels += is_background(normal, p) ? 0 : 1;
  }
}

// Everything that is drawn from one place.
function views_of(direction, times) {
  const side = look(sphere, direction, times);
  const by_filter = (model) => Object.fromEntries(
    Object.keys(kAnisotropy).map((filter) => [filter, shown(model, filter, side)]));
  const views = { side, result: by_filter(result), debug: by_filter(debug) };
  if (!truth) return views;
  return { ...views, truth: by_filter(truth), reference: ideal(truth, side), plain: ideal(result, side) };
}

// One row per filter, all directions taken together.
window.measure = (times, most_magenta, with_pictures) => {
  const all_views = directions(num_directions(times)).map((direction) => views_of(direction, times));
  return Object.keys(kAnisotropy).map((filter) => {
    const row = { filter, times, magenta: { share: 0, nearest: 255, above: 0, pixels: 0 } };
    const all = new_sums(), still = new_sums();
    let worst = { by: -Infinity };
    all_views.forEach((views, direction) => {
      look_for_magenta(views.result[filter], views.debug[filter], most_magenta, row.magenta);
      if (!truth) return;
      const one = new_sums(), one_still = new_sums();
      add_errors(views, filter, one, one_still);
      for (const key of Object.keys(one)) {
        all[key] += one[key];
        still[key] += one_still[key];
      }
      if (one.pixels > 0 && worse(one) > worst.by) worst = { by: worse(one), direction };
    });
    if (truth)
      Object.assign(row, { pixels: all.pixels, truth: rms(all, 'truth'), result: rms(all, 'result'),
                           worse: worse(all), worst, plain: rms(all, 'plain'),
                           moved: 1 - still.pixels / all.pixels, still_worse: worse(still) });
    if (with_pictures) row.picture = sheet(all_views.filter((_, i) => i % (all_views.length / kSheetRows) === 0), filter);
    return row;
  });
};

const kCell = 256;

// Pixels from the bottom up, drawn as a square cell of a sheet.
function draw(context, side, column, row, code_of) {
  const image = new ImageData(side, side);
  for (let p = 0; p < image.data.length; ++p) {
    const y = Math.floor(p / 4 / side), from = p + 4 * side * (side - 1 - 2 * y);
    image.data[p] = p % 4 === 3 ? 255 : code_of(from);
  }
  const cell = new OffscreenCanvas(side, side);
  cell.getContext('2d').putImageData(image, 0, 0);
  context.drawImage(cell, column * kCell, row * kCell, kCell, kCell);
}

// A row per direction, eight of them: reference, truth, result, 8 x the differences of both to the reference (grey
// is none; black where nothing is compared), debug background.
function sheet(all_views, filter) {
  const canvas = new OffscreenCanvas(6 * kCell, all_views.length * kCell);
  const context = canvas.getContext('2d');
  context.imageSmoothingEnabled = false;
  all_views.forEach((views, row) => {
    const { side, reference, plain } = views;
    const show = (column, code_of) => draw(context, side, column, row, code_of);
    const difference = (picture) => (p) => {
      const last = p - (p % 4) + 3;
      return reference[last] && plain[last] ? 128 + 8 * (picture[p] - to_code(reference[p])) : 0;
    };
    if (truth) {
      show(0, (p) => to_code(reference[p]));
      show(1, (p) => views.truth[filter][p]);
      show(3, difference(views.truth[filter]));
      show(4, difference(views.result[filter]));
    }
    show(2, (p) => views.result[filter][p]);
    show(5, (p) => views.debug[filter][p]);
  });
  return canvas;
}

// PNGs go to the script as base64.
window.as_png = async (canvas) => {
  const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
};

window.is_ready = true;
