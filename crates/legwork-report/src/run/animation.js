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
  const stages = [...figure.querySelectorAll(".stage")].map((svg, k) => ({
    ...data.stages[k], svg, world: svg.querySelector(".world"), pose: [...svg.querySelector(".pose").children],
  }));
  const [play, slider, clock, speed, state] = [".play", ".time", ".clock", ".speed", ".state"].map(find);
  const last = data.frames.length - 1;
  const end = last * data.period;
  const height = ([x, y]) => data.slopes[0] * x + data.slopes[1] * y; // of the ground at a place [m]
  let start = null; // height of the ground along x below the robot at the begin [m]
  let now = 0;        // [s]
  let playing = null; // when the latest frame was drawn [ms]
  const cursors = [];

  // Between two frames everything moves straight, save the pushes and the words, which hold.
  function row(time) {
    const place = Math.min(time / data.period, last);
    const index = Math.min(Math.floor(place), Math.max(last - 1, 0));
    const [a, b, share] = [data.frames[index], data.frames[Math.min(index + 1, last)], place - index];
    const near = share < 0.5 ? a : b;
    const held = a.length - 1 - 2 * data.axes * data.pushes;
    return near.map((value, k) => (k < held ? a[k] + share * (b[k] - a[k]) : value));
  }

  function draw() {
    const values = row(now);
    let next = 0;
    const vector = () => {
      const [x, ...rest] = Array.from({ length: data.axes }, () => values[next++]);
      return rest.length > 1 ? [x, ...rest] : [x, 0, rest[0]];
    };
    const metres = () => vector().map((value) => value / 1000);
    const many = (count, take) => Array.from({ length: count }, take);
    const points = many(data.points, metres);
    const marks = many(data.marks, metres);
    const com = metres();
    const forces = many(data.contacts.length, vector);
    const pushes = many(data.pushes, () => [vector(), metres()]);
    const contacts = data.contacts.map((point) => points[point]);

    for (const stage of stages) {
      let part = 0;
      start ??= height([com[0], 0]);
      const { pixel, cone, tip, push, net } = view(stage, height([com[0], 0]));
      const d = (path) => stage.pose[part++].setAttribute("d", path);
      const move = (point) => stage.pose[part++].setAttribute("transform", `translate(${pixel(point).map(tenth).join(" ")})`);
      contacts.forEach((point, k) => d(Math.hypot(...forces[k]) > 1 ? cone(point) : ""));
      data.links.forEach(([a, b]) => d(path([pixel(points[a]), pixel(points[b])])));
      data.joints.forEach((joint) => move(points[joint]));
      d(net(contacts, forces));
      contacts.forEach((point, k) => d(arrow(pixel(point), tip(point, forces[k]))));
      pushes.forEach(([force, at]) => d(push(force, at)));
      [...marks, com].forEach(move);
      const [across, down] = pixel(camera(stage, com));
      stage.world.setAttribute("transform", `translate(${tenth(stage.size[0] / 2 - across)} ${tenth(stage.size[1] - down)})`);
    }
    slider.value = Math.round(now / data.period);
    clock.textContent = `${now.toFixed(3)} s`;
    slider.setAttribute("aria-valuetext", clock.textContent);
    state.textContent = data.states[values.at(-1)] || "\u00a0";
    figure.dataset.time = now.toFixed(2);
    for (const show of cursors) show(now);
  }

  // Stands still where the whole run can be seen, else follows the centre of mass.
  function camera({ svg, across, range: [low, high] }, com) {
    const box = svg.getBoundingClientRect();
    const view = svg.viewBox.baseVal;
    const zoom = Math.max(box.width / view.width, box.height / view.height) || 1;
    const visible = box.width / zoom / data.scale;
    const place = [...com];
    if (high - low + 0.5 < visible) place[across] = (low + high) / 2;
    return [place[0], place[1], height(place)];
  }

  const tenth = (value) => Math.round(10 * value) / 10;
  const path = (line) => line.map((point, k) => (k ? "L" : "M") + point.map(tenth).join(" ")).join("");
  function arrow(tail, tip) {
    const [x, y] = [tip[0] - tail[0], tip[1] - tail[1]];
    const length = Math.hypot(x, y);
    if (!(length >= 2 && length < 1e6)) return "";
    const head = Math.min(11, length / 2) / length;
    const corner = (side) => [tip[0] - head * (x + side * 0.4 * y), tip[1] - head * (y - side * 0.4 * x)];
    return path([tail, [tip[0] - 0.8 * head * x, tip[1] - 0.8 * head * y]]) + path([corner(1), tip, corner(-1)]) + "Z";
  }

  // How a stage shows places and forces. From the front the ground stays as high as where the robot began.
  function view({ across, cone }, ground) {
    const base = across === 0 ? 0 : ground - start;
    const pixel = (point) => [data.scale * point[across], -data.scale * (point[2] - base)];
    const seen = (force) => [force[across], force[2]];
    const tip = (point, force) => pixel(point.map((value, k) => value + data.metres_per_newton * force[k]));
    return {
      pixel,
      tip,
      cone(point) {
        const [x, y] = pixel(point);
        const edge = ([a, b]) => [x + data.scale * data.cone_length * a, y - data.scale * data.cone_length * b];
        return path([edge(cone[0]), [x, y], edge(cone[1])]) + "Z";
      },
      push(force, at) {
        const [[x, y], [a, b]] = [pixel(at), seen(force)];
        const size = Math.hypot(a, b);
        if (size < 1) return "";
        const before = (distance) => [x - (distance * a) / size, y + (distance * b) / size];
        return arrow(before(8 + data.scale * data.metres_per_newton * size), before(8));
      },
      net(contacts, forces) {
        const sizes = forces.map((force) => Math.hypot(...force));
        const weight = Math.max(1e-9, sizes.reduce((sum, size) => sum + size, 0));
        const sum = (list, weights) => [0, 1, 2].map((k) => list.reduce((total, item, i) => total + weights[i] * item[k], 0));
        const centre = sum(contacts, sizes).map((value) => value / weight);
        return arrow(pixel(centre), tip(centre, sum(forces, sizes.map(() => 1))));
      },
    };
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
  stages.forEach(({ svg }) => svg.addEventListener("click", () => { figure.focus({ preventScroll: true }); toggle(); }));
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
