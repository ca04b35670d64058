// SPDX-License-Identifier: Apache-2.0
// Draws the clouds of a page of gnosphere view. It stands behind data.js.
'use strict';

const kNames = 60;  // entries of a legend; the rest is counted

const view = byId('view');
let renderer;
try {
  renderer = new THREE.WebGLRenderer({antialias: true});
} catch (error) {
  throw new Error('This browser has no WebGL, which the page needs to draw: ' + error.message);
}
renderer.setClearColor(0x0e1116);
renderer.setPixelRatio(window.devicePixelRatio);
view.appendChild(renderer.domElement);
const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(50, 1, 0.1, 1e5);
camera.up.set(0, 0, 1);
const controls = new THREE.OrbitControls(camera, renderer.domElement);
controls.screenSpacePanning = true;

const geometry = new THREE.BufferGeometry();
const material = new THREE.PointsMaterial({size: 2, sizeAttenuation: false, vertexColors: THREE.VertexColors});
const points = new THREE.Points(geometry, material);
points.frustumCulled = false;
const boxGroup = new THREE.Group(), ground = new THREE.Group();
scene.add(points, boxGroup, ground);

/// The middle of the cloud of the first frame, and how far most of it reaches from there.
function extentOf() {
  const {positions, count} = frameOf(0), middle = new THREE.Vector3();
  const axis = k => Float64Array.from({length: count}, (_, i) => positions[3 * i + k]).sort();
  const axes = [axis(0), axis(1), axis(2)], at = (values, share) => values[Math.floor(share * (count - 1))] || 0;
  middle.set(at(axes[0], 0.5), at(axes[1], 0.5), at(axes[2], 0.1));
  const distances = Float64Array.from({length: count}, (_, i) => Math.hypot(
    positions[3 * i] - middle.x, positions[3 * i + 1] - middle.y, positions[3 * i + 2] - middle.z)).sort();
  return {middle, reach: Math.max(at(distances, 0.8), 0.5), far: at(distances, 1), floor: at(axes[2], 0.02)};
}
const extent = extentOf(), headOrigin = new THREE.Vector3(...head.origin);

function look(x, y, z) {
  controls.target.copy(extent.middle);
  camera.position.set(x, y, z).multiplyScalar(extent.reach * 1.25).add(extent.middle);
  controls.update();
  draw();
}

/// Circles around the sensor on the ground, and the sensor's axes.
function addGround() {
  const unit = 10 ** Math.floor(Math.log10(Math.max(extent.reach, 1e-3)));
  for (let i = 1; i <= 10 && i * unit <= 2 * extent.far; ++i) {
    const circle = new THREE.BufferGeometry();
    circle.setFromPoints(Array.from({length: 129}, (_, k) => new THREE.Vector3(
      i * unit * Math.cos(k * Math.PI / 64), i * unit * Math.sin(k * Math.PI / 64), extent.floor)));
    ground.add(new THREE.Line(circle, new THREE.LineBasicMaterial({color: 0x28303b})));
  }
  const axes = new THREE.AxesHelper(Math.max(extent.reach / 25, 0.05));
  axes.position.z = -headOrigin.z;
  ground.add(axes);
  ground.position.set(-headOrigin.x, -headOrigin.y, 0);
  byId('help').append(document.createElement('br'), `circles: every ${unit} m; axes: x red, y green, z blue`);
}

// ---- colours, legend, boxes ----

let current = 0;                // the frame
const hidden = {};              // ids that are not shown, by the field's name
const field = () => fields[byId('field').value];

function textOf(field, value) {
  if (isNaN(value)) return 'none';
  if (field.id) return field.names[value] === undefined ? String(value) : field.names[value];
  return String(Number(value.toPrecision(6)));
}

function colourPoints() {
  const frame = frameOf(current), chosen = field(), values = frame.columns[chosen.name];
  const off = chosen.id ? hidden[chosen.name] : null, colours = new Uint8Array(3 * frame.count), shown = [];
  const span = chosen.id ? null : spanOf(chosen), known = new Map();
  for (let i = 0; i < frame.count; ++i) {
    const value = values[i];
    let colour = kNone;
    if (!isNaN(value) && chosen.id) {
      colour = known.get(value);
      if (!colour) known.set(value, colour = idColour(chosen, value));
    } else if (!isNaN(value)) {
      colour = rampColour(span.high > span.low ? (value - span.low) / (span.high - span.low) : 0.5);
    }
    colours.set(colour, 3 * i);
    if (!off || !off.has(String(value))) shown.push(i);
  }
  geometry.setAttribute('position', new THREE.BufferAttribute(frame.positions, 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3, true));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(shown), 1));
}

function element(kind, text, parent, name) {
  const made = document.createElement(kind);
  if (text !== undefined) made.textContent = text;
  if (name) made.className = name;
  parent.appendChild(made);
  return made;
}

function numberLegend(chosen, legend) {
  const span = spanOf(chosen), bar = element('div', undefined, legend);
  bar.id = 'bar';
  bar.style.background = `linear-gradient(to right, ${kRamp.map(c => `rgb(${c})`).join(', ')})`;
  const ticks = element('div', undefined, legend);
  ticks.id = 'ticks';
  const digits = Math.min(Math.max(Math.ceil(2 - Math.log10(span.high - span.low || 1)), 0), 12);
  const text = value => String(Number(value.toFixed(digits)));
  element('span', (span.below ? '≤ ' : '') + text(span.low), ticks);
  element('span', text((span.low + span.high) / 2), ticks);
  element('span', (span.above ? '≥ ' : '') + text(span.high), ticks);
}

function idLegend(chosen, legend) {
  const counts = new Map(), off = hidden[chosen.name] = hidden[chosen.name] || new Set();
  for (const value of frameOf(current).columns[chosen.name]) counts.set(value, (counts.get(value) || 0) + 1);
  const byCount = [...counts].sort((a, b) => b[1] - a[1]), most = byCount.slice(0, kNames);
  if (byCount.length <= kNames) most.sort((a, b) => a[0] - b[0]);
  for (const [value, count] of most) {
    const entry = element('div', undefined, legend, 'entry' + (off.has(String(value)) ? ' off' : ''));
    element('i', undefined, entry).style.background = `rgb(${isNaN(value) ? kNone : idColour(chosen, value)})`;
    element('b', textOf(chosen, value), entry);
    element('span', count.toLocaleString('en'), entry, 'quiet');
    entry.title = 'click to hide or show';
    entry.onclick = () => {
      if (!off.delete(String(value))) off.add(String(value));
      show(current);
    };
  }
  if (byCount.length > kNames) element('div', `and ${byCount.length - kNames} more with fewer points`, legend, 'quiet');
}

const tags = [];  // {element, position}

function addBoxes(info) {
  boxGroup.children.slice().forEach(box => boxGroup.remove(box));
  tags.splice(0).forEach(tag => tag.element.remove());
  if (!byId('showBoxes').checked) return;
  for (const box of info.boxes) {
    const edges = new THREE.EdgesGeometry(new THREE.BoxBufferGeometry(...box.size));
    const lines = new THREE.LineSegments(edges, new THREE.LineBasicMaterial({color: box.moving ? 0xffb02e : 0x8fd3ff}));
    lines.position.set(...box.position).sub(headOrigin);
    lines.quaternion.set(...box.orientation);
    boxGroup.add(lines);
    const tag = element('div', `${box.name}, ${box.class}, ${box.points} points`, byId('tags'), 'tag');
    const top = lines.position.clone().add(new THREE.Vector3(0, 0, box.size[2] / 2));
    tags.push({element: tag, position: top});
  }
}

function placeTags() {
  for (const {element, position} of tags) {
    const at = position.clone().project(camera), seen = at.z < 1 && Math.abs(at.x) < 1.1 && Math.abs(at.y) < 1.1;
    element.style.display = seen ? '' : 'none';
    const x = (at.x + 1) / 2 * window.innerWidth, y = (1 - at.y) / 2 * window.innerHeight;
    element.style.transform = `translate(${x}px, ${y}px) translate(-50%, -120%)`;
  }
}

// ---- the page ----

let drawing = false;
/// Draws once before the browser shows the next picture, however often this is called.
function draw() {
  if (!drawing) requestAnimationFrame(() => {
    drawing = false;
    renderer.render(scene, camera);
    placeTags();
  });
  drawing = true;
}

function show(index) {
  current = index;
  const {info, count} = frameOf(index), legend = byId('legend');
  colourPoints();
  addBoxes(info);
  legend.textContent = '';
  (field().id ? idLegend : numberLegend)(field(), legend);
  byId('frame').value = index;
  byId('name').textContent = info.name;
  const lines = [`${count.toLocaleString('en')} points` + (head.every > 1 ? `, one of ${head.every} is shown` : '')];
  if (info.misses) lines.push(`${info.misses.toLocaleString('en')} beams without a point`);
  // Half a step, and the rounding of the 32-bit numbers from the head's origin from which the positions come.
  const error = info.step / 2 + Math.max(...info.origin.map((x, i) => Math.abs(x - head.origin[i]))) * 2 ** -24;
  lines.push(`positions to ${Number((1000 * error).toPrecision(2))} mm`, ...head.notes);
  byId('about').textContent = '';
  lines.forEach(line => element('div', line, byId('about')));
  byId('picked').hidden = true;
  draw();
}

/// Shows the values of the point nearest to the pointer.
function pick(event) {
  const frame = frameOf(current), at = new THREE.Vector3(), index = geometry.index.array;
  let best = -1, least = 8 * 8;
  for (const i of index) {
    at.fromArray(frame.positions, 3 * i).project(camera);
    if (at.z > 1) continue;
    const dx = (at.x + 1) / 2 * window.innerWidth - event.clientX;
    const dy = (1 - at.y) / 2 * window.innerHeight - event.clientY;
    if (dx * dx + dy * dy < least) [best, least] = [i, dx * dx + dy * dy];
  }
  byId('picked').hidden = best < 0;
  if (best < 0) return;
  byId('picked').textContent = '';
  const table = element('table', undefined, byId('picked'));
  const line = (name, text) => {
    const row = element('tr', undefined, table);
    element('td', name, row);
    element('td', text, row);
  };
  ['x', 'y', 'z'].forEach((name, axis) =>
    line(name, (head.origin[axis] + frame.positions[3 * best + axis]).toFixed(3) + ' m'));
  for (const each of fields) if (each.name !== 'z') line(each.name, textOf(each, frame.columns[each.name][best]));
}

function resize() {
  camera.aspect = window.innerWidth / window.innerHeight;
  camera.updateProjectionMatrix();
  renderer.setSize(window.innerWidth, window.innerHeight);
  draw();
}

let playing = null;
function play() {
  byId('play').textContent = playing ? 'play' : 'pause';
  if (playing) {
    clearInterval(playing);
    playing = null;
  } else {
    playing = setInterval(() => show((current + 1) % head.frames.length), 100);
  }
}

document.title = head.title + ' - GnoSphere';
byId('title').textContent = head.title;
fields.forEach((each, i) => element('option', each.name, byId('field')).value = i);
const wished = [head.colour, 'class', 'intensity', 'range'].map(name => fields.findIndex(each => each.name === name));
byId('field').value = wished.find(i => i >= 0);
byId('time').hidden = head.frames.length < 2;
byId('frame').max = head.frames.length - 1;
byId('boxes').hidden = !head.frames.some(frame => frame.boxes.length > 0);

byId('field').onchange = () => show(current);
byId('frame').oninput = () => show(Number(byId('frame').value));
byId('showBoxes').onchange = () => show(current);
byId('size').oninput = () => {
  material.size = Number(byId('size').value);
  draw();
};
byId('play').onclick = play;
byId('start').onclick = () => look(-0.9, -0.45, 0.75);
byId('top').onclick = () => look(-0.001, 0, 1.4);
let pressed = [0, 0];
renderer.domElement.addEventListener('mousedown', event => pressed = [event.clientX, event.clientY]);
renderer.domElement.addEventListener('click', event => {
  if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4) pick(event);
});
window.addEventListener('keydown', event => {
  const step = {ArrowRight: 1, ArrowLeft: -1}[event.key], count = head.frames.length;
  if (step && !['INPUT', 'SELECT'].includes(event.target.tagName)) show((current + step + count) % count);
});
window.addEventListener('resize', resize);
controls.addEventListener('change', draw);
addGround();
show(0);
resize();
byId('start').onclick();
