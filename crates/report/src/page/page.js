// Time, and what every panel shows at it.

const run = JSON.parse(document.getElementById("run").textContent);
const { rows } = run;
const byId = (id) => document.getElementById(id);
const CABLES = run.anchors.map((_, i) => i);
const COORDINATES = ["x", "y", "z"];
const metres = (value) => (Math.abs(value) < 5e-5 ? 0 : value).toFixed(4);
const newtons = (value) => (value === null ? "–" : (Math.abs(value) < 5e-4 ? 0 : value).toFixed(3));
const radians = (angles) => angles.map((angle) => (Math.abs(angle) < 5e-5 ? 0 : angle).toFixed(4)).join(", ");

/** Row drawn nearest to `time`. */
function rowAt(time) {
  let [low, high] = [0, rows.time.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rows.time[middle] <= time) low = middle; else high = middle;
  }
  return time - rows.time[low] <= rows.time[high] - time ? low : high;
}

// ---- panels

const robot = scene(byId("scene"), run);
const view = plane(byId("plane-picture"), run);
byId("ramp-end").textContent = `${run.colourTop.toFixed(1)} N and more`;
byId("reset-view").addEventListener("click", robot.reset);

const setPointColumn = (k) => {
  let active = 0;
  return rows.time.map((_, row) => {
    while (active + 1 < run.setPoints.length && run.setPoints[active + 1].row <= row) active++;
    return run.setPoints[active].pose[k];
  });
};

const colours = ["--c1", "--c2", "--c3"];
const swatch = (kind, colour = "--ink") =>
  `<svg width="24" height="8" aria-hidden="true"><path class="${kind}" style="stroke: var(${colour})" d="M1 4H23"/></svg>`;

/** A line of names and outputs above a chart, and the chart's box. */
function chartWithHead(parent, html) {
  const head = document.createElement("div"), box = document.createElement("div");
  head.className = "chart-head";
  head.innerHTML = html;
  parent.append(head, box);
  return { box, outputs: [...head.querySelectorAll("output")] };
}

const positions = COORDINATES.map((name, k) => {
  const { box, outputs } = chartWithHead(byId("positions-charts"),
    `<b>${name} (m)</b><span>${swatch("line", colours[k])}platform <output id="now-${name}"></output></span><span>${swatch("dashed")}set point <output id="now-set-${name}"></output></span>`);
  const setPoint = setPointColumn(k);
  const lines = [
    { values: setPoint, colour: "--ink", dash: [5, 4], step: true },
    { values: rows.pose[k], colour: colours[k], name },
  ];
  const drawn = chart(box, run, {
    label: `${name} of platform and set point over time`, height: k === 2 ? 186 : 152, range: rangeOf([setPoint, rows.pose[k]], 0.02),
    lines, last: k === 2, scrub: seek,
  });
  const show = (row) => {
    drawn.show(row);
    outputs[0].textContent = metres(rows.pose[k][row]);
    outputs[1].textContent = metres(setPoint[row]);
  };
  return { ...drawn, show };
});

/** Roll, pitch and yaw in one chart, if the platform turns at all. */
function anglesChart() {
  const angles = rows.pose.slice(3);
  const setPoints = [3, 4, 5].map(setPointColumn);
  if ([...angles, ...setPoints].flat().every((angle) => Math.abs(angle) < 1e-3)) return [];
  const names = ["roll", "pitch", "yaw"], angleColours = ["--c4", "--c5", "--c6"];
  const { box, outputs } = chartWithHead(byId("positions-charts"),
    "<b>turned (rad), R = Rz(yaw) Ry(pitch) Rx(roll)</b>" + names.map((name, k) => `<span>${swatch("line", angleColours[k])}${name} <output id="now-${name}"></output></span>`).join(""));
  const lines = [
    ...setPoints.map((values) => ({ values, colour: "--ink", dash: [4, 7], step: true })),
    ...angles.map((values, k) => ({ values, colour: angleColours[k], name: ["r", "p", "y"][k] })),
  ];
  const drawn = chart(box, run, {
    label: "Roll, pitch and yaw over time", height: 186, range: rangeOf([...angles, ...setPoints], 0.02), lines, last: true, scrub: seek,
  });
  const show = (row) => {
    drawn.show(row);
    outputs.forEach((output, k) => { output.textContent = angles[k][row].toFixed(4); });
  };
  return [{ ...drawn, show }];
}
positions.push(...anglesChart());

function tensionRange() {
  const top = run.tensionTop, [low, high] = rangeOf([...rows.tension, ...(rows.predicted ?? [])], 1);
  return [Math.max(-0.4 * top, Math.min(low, -0.03 * top)), Math.min(high, 1.5 * top)];
}

const tensionLines = [
  ...CABLES.map((i) => ({ values: rows.tension[i], colour: `--c${(i % 6) + 1}`, name: `u${i + 1}` })),
  ...(rows.predicted ?? []).map((values) => ({ values, colour: "--ink", dash: [4, 7] })),
];
const tension = chart(byId("tension-chart"), run, {
  label: "Tensions of the cables over time", height: 270, range: tensionRange(), lines: tensionLines,
  limits: [run.limits.min, run.limits.max].filter((value) => value !== null), scrub: seek,
});
const marginHead = chartWithHead(byId("margin-chart"),
  `<b>smallest (N)</b><span>${swatch("line", "--p")}predicted from now on <output id="now-margin"></output></span><span>${swatch("dotted", "--soft")}now <output id="now-smallest"></output></span>`);
const smallest = rows.time.map((_, row) => Math.min(...rows.tension.map((column) => column[row])));
const [marginLow, marginHigh] = rangeOf([rows.margin, smallest, [0]], 1);
const margin = chart(marginHead.box, run, {
  label: "Margin and smallest tension over time", height: 150, range: [Math.max(marginLow, -marginHigh), marginHigh], last: true, limits: [run.limits.min], scrub: seek,
  lines: [{ values: smallest, colour: "--soft", dash: [2, 3] }, { values: rows.margin, colour: "--p", step: true }],
});

const cells = { measured: [], predicted: [] };
for (const i of CABLES) {
  const head = byId("tension-values").tHead.rows[0].appendChild(document.createElement("th"));
  head.scope = "col";
  head.innerHTML = `<button type="button" aria-pressed="false" aria-label="Show cable ${i + 1} alone" style="border-color: var(--c${(i % 6) + 1})">u${i + 1}</button>`;
  head.firstChild.addEventListener("click", () => alone(i));
  for (const kind in cells) {
    cells[kind].push(byId(kind).appendChild(document.createElement("td")));
    cells[kind][i].id = `${kind}-${i + 1}`;
  }
}

/** Fades all cables but one; again, and all are back. */
function alone(cable) {
  const buttons = [...byId("tension-values").querySelectorAll("button")];
  const on = buttons[cable].getAttribute("aria-pressed") !== "true";
  buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(on && i === cable)));
  tension.focus(on ? cable : null);
}

// ---- values at the cursor

function slackCables(row) {
  const slack = CABLES.filter((i) => isSlack(run, row, i)).map((i) => i + 1);
  return slack.length ? `<span class="bad">slack: cable ${slack.join(", ")}</span>` : "all cables taut";
}

function describeRobot(row) {
  const at = COORDINATES.map((_, k) => metres(rows.pose[k][row])).join(", ");
  const turned = rows.pose.slice(3).map((column) => column[row]);
  const angles = turned.some((angle) => Math.abs(angle) > 1e-3) ? `, roll, pitch, yaw (${radians(turned)}) rad` : "";
  const state = rows.status ? run.statuses[rows.status[row] - 1] ?? "" : "";
  byId("robot-now").innerHTML = `<b>(${at}) m</b>${angles} · set point ${run.setPoints[activeAt(run.setPoints, row)].number} of ${run.lastSetPoint}${state && ` · ${state}`} · ${slackCables(row)}`;
}

/** Which facets p is nearest to. */
function nearest(cables) {
  const numbers = cables.map((i) => i + 1);
  if (numbers.length === 1) return `facet ${numbers[0]}, the nearest`;
  return numbers.length === CABLES.length ? "every facet, equally near" : `facets ${numbers.join(", ")}, equally near`;
}

/** What p says of the cables: of facets at zero orientation only, and that a cable would have to push only where it is slack. */
function describeP(row) {
  const near = nearestFacet(run, row);
  if (!near) { byId("plane-now").textContent = "No p here: the law is idle, or asks the cables for a force that points down."; return; }
  const [x, y] = near.p.map(metres), gap = (Math.abs(near.distance) * 1000).toFixed(1), cable = near.cable + 1;
  const where = near.turned
    ? `${slackCables(row)} <small>(turned: the facets are those of zero orientation and tell nothing here)</small>`
    : near.distance > 0 ? `${gap} mm inside ${nearest(near.cables)}`
      : near.slack ? `<span class="bad">${gap} mm beyond facet ${cable}: cable ${cable} would have to push</span>`
        : `${gap} mm beyond facet ${cable}; cable ${cable} still pulls`;
  byId("plane-now").innerHTML = `<b>p = (${x}, ${y}) m</b> · ${where}`;
}

function describeTensions(row) {
  for (const i of CABLES) {
    cells.measured[i].textContent = newtons(rows.tension[i][row]);
    cells.measured[i].className = isSlack(run, row, i) ? "bad" : "";
    cells.predicted[i].textContent = newtons(rows.predicted ? rows.predicted[i][row] : null);
    cells.predicted[i].className = rows.predicted && rows.predicted[i][row] < 0 ? "bad" : "";
  }
  byId("now-margin").textContent = newtons(rows.margin[row]);
  byId("now-smallest").textContent = newtons(smallest[row]);
}

const list = byId("set-points").querySelector(".tall");
const listed = [...byId("set-points").querySelectorAll("tbody tr")];
let row = -1;

function show(to) {
  if (to === row) return;
  row = to;
  const time = rows.time[row], active = run.setPoints[activeAt(run.setPoints, row)].number;
  for (const panel of [robot, view, ...positions, tension, margin]) panel.show(row);
  describeRobot(row);
  describeP(row);
  describeTensions(row);
  listed.forEach((line, i) => line.classList.toggle("active", i === active));
  if (listed[active]) list.scrollTop = listed[active].offsetTop - list.clientHeight / 2;
  slider.value = time;
  slider.setAttribute("aria-valuetext", `${time.toFixed(3)} seconds, smallest tension ${newtons(smallest[row])} newtons`);
  byId("clock").innerHTML = `<b>${time.toFixed(3)}</b> s <span>of ${rows.time.at(-1).toFixed(2)} s</span>`;
}

// ---- time

const [start, end] = [rows.time[0], rows.time.at(-1)];
const slider = byId("time");
const calm = matchMedia("(prefers-reduced-motion: reduce)");
let playing = null, now = start;

/** Where someone pointed or stepped to; playing stops. */
function seek(time) {
  stop();
  now = Math.min(end, Math.max(start, time));
  show(rowAt(now));
}

function stop() {
  playing = null;
  set(byId("play"), { "aria-label": "Play" });
  set(byId("play-icon"), { d: "M7 4v16l13-8z" });
}

function play() {
  if (now >= end) now = start;
  playing = performance.now();
  set(byId("play"), { "aria-label": "Pause" });
  set(byId("play-icon"), { d: "M6 4h4v16H6zM14 4h4v16h-4z" });
  requestAnimationFrame(frame);
}

/** Plays on; who asked for little motion sees four pictures a second. */
function frame(clock) {
  if (playing === null) return;
  const passed = clock - playing;
  if (passed >= (calm.matches ? 250 : 0)) {
    playing = clock;
    now = Math.min(end, now + (Math.max(0, passed) / 1000) * Number(byId("speed").value));
    show(rowAt(now));
  }
  if (now >= end) stop(); else requestAnimationFrame(frame);
}

const toggle = () => (playing === null ? play() : stop());
slider.min = start;
slider.max = end > start ? end : start + 1;
slider.addEventListener("input", () => seek(Number(slider.value)));
byId("play").addEventListener("click", toggle);
document.addEventListener("keydown", (event) => {
  const { key, target, shiftKey } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || target.matches("select") || (key === " " && target.matches("button"))) return;
  if (target.matches(".tall") && key.startsWith("Arrow")) return;
  const step = (end - start) / (shiftKey ? 20 : 200);
  const keys = {
    " ": toggle, Home: () => seek(start), End: () => seek(end),
    ArrowRight: () => seek(now + step), ArrowLeft: () => seek(now - step),
  };
  if (slider === target) Object.assign(keys, { ArrowUp: keys.ArrowRight, ArrowDown: keys.ArrowLeft });
  if (!keys[key]) return;
  event.preventDefault();
  keys[key]();
});

for (const { row: at } of run.manySetPoints ? [] : run.setPoints.slice(1)) mark("step", rows.time[at], rows.time[at]);
for (const [from, to] of run.disturbedSpans) mark("disturbed-span", from, to);
for (const [from, to] of run.slackSpans) mark("slack-span", from, to);
function mark(kind, from, to) {
  const share = (time) => (100 * (time - start)) / (Number(slider.max) - start);
  const line = byId("marks").appendChild(document.createElement("i"));
  line.className = kind;
  line.style.left = `${share(from)}%`;
  if (to > from) line.style.width = `${share(to) - share(from)}%`;
}

// Paper is white, whatever the screen is.
for (const query of ["(prefers-color-scheme: dark)", "print"]) {
  matchMedia(query).addEventListener("change", () => [...positions, tension, margin].forEach((panel) => panel.redraw()));
}
show(0);
