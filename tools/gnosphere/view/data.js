// SPDX-License-Identifier: Apache-2.0
// The clouds of a page of gnosphere view, and the colours of their values; page.hpp says how they are stored. The
// page's elements are found by their ids.
'use strict';

const byId = id => document.getElementById(id);
window.onerror = message => {
  byId('problem').textContent = String(message);
  byId('problem').hidden = false;
};

const head = JSON.parse(byId('head').textContent);

// Numbers from low to high: the colours of Turbo without its dark ends.
const kRamp = [[70, 98, 215], [54, 170, 249], [26, 228, 182], [114, 254, 94], [200, 239, 52], [250, 186, 57],
               [246, 107, 25], [203, 42, 4]];
const kNone = [90, 98, 110];  // of points without a value
const kDifferences = {0: [84, 94, 108], 1: [255, 176, 46], 2: [64, 160, 255], 3: [255, 84, 84]};

function rampColour(share) {
  const at = Math.min(Math.max(share, 0), 1) * (kRamp.length - 1), low = Math.min(Math.floor(at), kRamp.length - 2);
  return kRamp[low].map((c, i) => c + (kRamp[low + 1][i] - c) * (at - low));
}

/// A colour of its own for each id, in the order in which ids appear; those of the first frame by their numbers.
function idColour(field, id) {
  if (field.name === 'difference') return kDifferences[id];
  if (!field.ranks)
    field.ranks = new Map(Array.from(new Set(frameOf(0).columns[field.name].filter(value => !isNaN(value)).sort()),
                                     (value, i) => [value, i]));
  if (!field.ranks.has(id)) field.ranks.set(id, field.ranks.size);
  const rank = field.ranks.get(id), bright = 235, dark = rank % 2 ? 70 : 105;
  const hue = (rank * 0.61803398875 + 0.55) % 1 * 6;  // the golden ratio keeps the hues of all ranks apart
  const part = n => {
    const k = (n + hue) % 6;
    return bright - (bright - dark) * Math.max(0, Math.min(k, 4 - k, 1));
  };
  return [part(5), part(3), part(1)];
}

const decoded = [];

/// The points of a frame, from the head's origin, and its columns; a column has NaN where a point has no value.
function frameOf(index) {
  if (decoded[index]) return decoded[index];
  const info = head.frames[index], count = info.points, text = atob(byId('frame' + index).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  let at = 0;
  const numbers = size => {
    const part = bytes.slice(at, at += count * size).buffer;
    return size === 1 ? new Uint8Array(part) : size === 2 ? new Uint16Array(part) : new Uint32Array(part);
  };
  const positions = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; ++axis) {
    const steps = numbers(2);
    const start = info.origin[axis] - head.origin[axis];
    for (let i = 0; i < count; ++i) positions[3 * i + axis] = start + steps[i] * info.step;
  }
  const columns = {};
  for (const field of head.fields) {
    const codes = numbers(field.bytes), none = 2 ** (8 * field.bytes) - 1, scale = (field.max - field.min) / 65534;
    columns[field.name] = Float64Array.from(codes, code => code === none ? NaN : field.id ? code :
                                            field.min + code * scale);
  }
  const coordinate = (i, axis) => head.origin[axis] + positions[3 * i + axis];
  columns.z = columns.z || Float64Array.from({length: count}, (_, i) => coordinate(i, 2));
  columns.range = columns.range || Float64Array.from({length: count}, (_, i) => Math.hypot(
    coordinate(i, 0), coordinate(i, 1), coordinate(i, 2)));
  return decoded[index] = {info, count, positions, columns};
}

const fields = head.fields.slice();
for (const name of ['range', 'z'])
  if (!fields.some(field => field.name === name)) fields.push({name, id: false, names: {}});

/// The values between which 98 of 100 values of the first frame lie, so that a few extremes do not take all colours.
function spanOf(field) {
  if (field.span) return field.span;
  const values = frameOf(0).columns[field.name].filter(value => !isNaN(value)).sort();
  if (values.length === 0) return field.span = {low: 0, high: 1, below: false, above: false};
  const low = values[Math.floor(0.01 * (values.length - 1))], high = values[Math.ceil(0.99 * (values.length - 1))];
  return field.span = {low, high, below: values[0] < low, above: values[values.length - 1] > high};
}
