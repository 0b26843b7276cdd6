// Moves the stick figures: each animation reads its frames and sets what the page has drawn of the first one.
"use strict";

window.addEventListener("error", (event) => { document.documentElement.dataset.error = event.message; });
const seekers = new Map(); // by the scenario's name, as an address spells it
for (const figure of document.querySelectorAll(".animation")) animate(figure);
window.addEventListener("hashchange", open);
open();
document.documentElement.dataset.animation = "ready";

// An address that ends with #walk@2.00 shows the walk at 2 s.
function open() {
  const [, scenario, time] = location.hash.match(/^#(.+)@([0-9.]+)$/) ?? [];
  seekers.get(scenario)?.(Number(time));
}

function animate(figure) {
  const find = (selector) => figure.querySelector(selector);
  const data = JSON.parse(find(".frames").textContent);
  const [world, pose, stage] = [find(".world"), [...find(".pose").children], find(".stage")];
  const [play, slider, clock, speed, state] = [".play", ".time", ".clock", ".speed", ".state"].map(find);
  const last = data.frames.length - 1;
  const end = last * data.period;
  let now = 0;        // [s]
  let playing = null; // when the latest frame was drawn [ms]
  const cursors = [];

  // Between two frames everything moves straight, save the pushes and the words, which hold.
  function row(time) {
    const place = Math.min(time / data.period, last);
    const index = Math.min(Math.floor(place), Math.max(last - 1, 0));
    const [a, b, share] = [data.frames[index], data.frames[Math.min(index + 1, last)], place - index];
    const near = share < 0.5 ? a : b;
    const held = a.length - 1 - 4 * data.pushes;
    return near.map((value, k) => (k < held ? a[k] + share * (b[k] - a[k]) : value));
  }

  function draw() {
    const values = row(now);
    let next = 0;
    const pair = () => [values[next++], values[next++]];
    const metres = () => pair().map((value) => value / 1000);
    const many = (count, take) => Array.from({ length: count }, take);
    const points = many(data.points, metres);
    const [com, reference, xcom, right, left] = many(5, metres);
    const forces = many(data.contacts.length, pair);
    const pushes = many(data.pushes, () => [pair(), metres()]);
    const contacts = data.contacts.map((point) => points[point]);

    let part = 0;
    const d = (path) => pose[part++].setAttribute("d", path);
    const move = (point) => pose[part++].setAttribute("transform", `translate(${pixel(point).map(tenth).join(" ")})`);
    contacts.forEach((point, k) => d(Math.hypot(...forces[k]) > 1 ? cone(point) : ""));
    data.links.forEach(([a, b]) => d(path([pixel(points[a]), pixel(points[b])])));
    data.joints.forEach((joint) => move(points[joint]));
    d(net(contacts, forces));
    contacts.forEach((point, k) => d(arrow(pixel(point), tip(point, forces[k]))));
    pushes.forEach(([force, at]) => d(push(force, at)));
    [right, left, xcom, reference, com].forEach(move);

    const [x, height] = camera(com);
    const [across, down] = pixel([x, height]);
    world.setAttribute("transform", `translate(${tenth(data.stage[0] / 2 - across)} ${tenth(data.stage[1] - down)})`);
    slider.value = Math.round(now / data.period);
    clock.textContent = `${now.toFixed(3)} s`;
    slider.setAttribute("aria-valuetext", clock.textContent);
    state.textContent = data.states[values.at(-1)];
    figure.dataset.time = now.toFixed(2);
    for (const show of cursors) show(now);
  }

  // Stands still where the whole run can be seen, else follows the centre of mass.
  function camera(com) {
    const box = stage.getBoundingClientRect();
    const view = stage.viewBox.baseVal;
    const zoom = Math.max(box.width / view.width, box.height / view.height) || 1;
    const visible = box.width / zoom / data.scale;
    const [low, high] = data.range;
    const x = high - low + 0.5 < visible ? (low + high) / 2 : com[0];
    return [x, data.slope * x];
  }

  const tenth = (value) => Math.round(10 * value) / 10;
  const pixel = ([x, z]) => [data.scale * x, -data.scale * z];
  const path = (line) => line.map((point, k) => (k ? "L" : "M") + point.map(tenth).join(" ")).join("");
  const along = (point, direction, length) => point.map((value, k) => value + length * direction[k]);
  const tip = (point, force) => pixel(along(point, force, data.metres_per_newton));
  const cone = (point) => {
    const edges = data.cone.map((edge) => pixel(along(point, edge, data.cone_length)));
    return path([edges[0], pixel(point), edges[1]]) + "Z";
  };
  function arrow(tail, tip) {
    const [x, y] = [tip[0] - tail[0], tip[1] - tail[1]];
    const length = Math.hypot(x, y);
    if (!(length >= 2 && length < 1e6)) return "";
    const head = Math.min(11, length / 2) / length;
    const corner = (side) => [tip[0] - head * (x + side * 0.4 * y), tip[1] - head * (y - side * 0.4 * x)];
    return path([tail, [tip[0] - 0.8 * head * x, tip[1] - 0.8 * head * y]]) + path([corner(1), tip, corner(-1)]) + "Z";
  }
  function push(force, at) {
    const [[x, y], size] = [pixel(at), Math.hypot(...force)];
    if (!size) return "";
    const before = (distance) => [x - (distance * force[0]) / size, y + (distance * force[1]) / size];
    return arrow(before(8 + data.scale * data.metres_per_newton * size), before(8));
  }
  function net(contacts, forces) {
    const sizes = forces.map((force) => Math.hypot(...force));
    const weight = Math.max(1e-9, sizes.reduce((sum, size) => sum + size, 0));
    const sum = (list, weights) => [0, 1].map((k) => list.reduce((total, item, i) => total + weights[i] * item[k], 0));
    const centre = sum(contacts, sizes).map((value) => value / weight);
    return arrow(pixel(centre), tip(centre, sum(forces, sizes.map(() => 1))));
  }

  function seek(time) {
    now = Math.min(Math.max(time, 0), end);
    draw();
  }

  function setPlaying(on) {
    playing = on ? performance.now() : null;
    play.textContent = on ? "\u275a\u275a" : "\u25b6";
    play.setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) return;
    if (now >= end) now = 0;
    requestAnimationFrame(advance);
  }

  function advance(moment) {
    if (playing === null) return;
    seek(now + (Math.max(moment - playing, 0) / 1000) * speed.value);
    playing = moment;
    if (now >= end) setPlaying(false);
    else requestAnimationFrame(advance);
  }

  const toggle = () => setPlaying(playing === null);
  play.addEventListener("click", toggle);
  slider.addEventListener("input", () => { setPlaying(false); seek(slider.value * data.period); });
  stage.addEventListener("click", () => { figure.focus({ preventScroll: true }); toggle(); });
  figure.addEventListener("keydown", (event) => {
    if (event.target === speed || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target === play && [" ", "Enter"].includes(event.key)) return;
    const frames = event.shiftKey ? 10 : 1;
    const step = (count) => { setPlaying(false); seek((Math.round(now / data.period) + count) * data.period); };
    const actions = {
      " ": toggle,
      ArrowLeft: () => step(-frames),
      ArrowRight: () => step(frames),
      Home: () => seek(0),
      End: () => seek(end),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });

  // The charts of the same run show the time, and can be clicked to move to it.
  for (const chart of figure.closest("article").querySelectorAll("svg[data-span]")) {
    const [time, across, down] = ["span", "across", "down"].map((name) => chart.dataset[name].split(" ").map(Number));
    const cursor = document.createElementNS("http://www.w3.org/2000/svg", "path");
    cursor.setAttribute("class", "cursor");
    chart.append(cursor);
    chart.classList.add("seekable");
    cursors.push((now) => {
      const x = across[0] + ((now - time[0]) / (time[1] - time[0])) * (across[1] - across[0]);
      cursor.setAttribute("d", `M${tenth(x)} ${down[0]}V${down[1]}`);
    });
    chart.addEventListener("click", (event) => {
      const box = chart.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * chart.viewBox.baseVal.width;
      setPlaying(false);
      seek(time[0] + ((x - across[0]) / (across[1] - across[0])) * (time[1] - time[0]));
    });
  }

  window.addEventListener("resize", draw);
  figure.hidden = false;
  draw();
  seekers.set(encodeURIComponent(figure.dataset.scenario), (time) => {
    setPlaying(false);
    seek(time);
    figure.scrollIntoView();
  });
}
