// What every panel shows at a time.

const run = JSON.parse(document.getElementById("run").textContent);
const { rows } = run;
const CABLES = run.anchors.map((_, i) => i);
const radians = (angles) => angles.map((angle) => (Math.abs(angle) < 5e-5 ? 0 : angle).toFixed(4)).join(", ");

const [start, end] = [rows.time[0], run.end];
const { seek, mark, moved } = transport(start, end, (time) => show(rowAt(rows.time, time)));

// ---- panels

const robot = scene(byId("scene"), run);
const view = plane(byId("plane-picture"), run);
byId("ramp-end").textContent = `${run.colourTop.toFixed(1)} N and more`;
byId("reset-view").addEventListener("click", robot.reset);

const colours = ["--c1", "--c2", "--c3"];
/** What the law follows, over the platform's line where it is not the set point. */
const referenceLines = (k) => (rows.reference ? [{ values: rows.reference[k], colour: "--ink", dash: [2, 5] }] : []);

const positions = COORDINATES.map((name, k) => {
  const { box, outputs } = chartWithHead(byId("positions-charts"),
    `<b>${name} (m)</b><span>${swatch("line", colours[k])}platform <output id="now-${name}"></output></span><span>${swatch("dashed")}set point <output id="now-set-${name}"></output></span>${
      rows.reference ? `<span>${swatch("dotted")}reference <output id="now-reference-${name}"></output></span>` : ""}`);
  const setPoint = setPointColumn(run, k);
  const lines = [
    { values: setPoint, colour: "--ink", dash: [5, 4], step: true },
    { values: rows.pose[k], colour: colours[k], name },
    ...referenceLines(k),
  ];
  const drawn = chart(box, run, {
    label: `${name} of platform and set point over time`, height: k === 2 ? 186 : 152, range: rangeOf([setPoint, rows.pose[k]], 0.02),
    lines, last: k === 2, scrub: seek,
  });
  const show = (row) => {
    drawn.show(row);
    outputs[0].textContent = metres(rows.pose[k][row]);
    outputs[1].textContent = metres(setPoint[row]);
    if (rows.reference) outputs[2].textContent = metres(rows.reference[k][row] ?? setPoint[row]);
  };
  return { ...drawn, show };
});

/** Roll, pitch and yaw in one chart, if the platform turns at all. */
function anglesChart() {
  const angles = rows.pose.slice(3);
  const setPoints = [3, 4, 5].map((k) => setPointColumn(run, k));
  if ([...angles, ...setPoints].flat().every((angle) => Math.abs(angle) < 1e-3)) return [];
  const names = ["roll", "pitch", "yaw"], angleColours = ["--c4", "--c5", "--c6"];
  const { box, outputs } = chartWithHead(byId("positions-charts"),
    "<b>turned (rad), R = Rz(yaw) Ry(pitch) Rx(roll)</b>" + names.map((name, k) => `<span>${swatch("line", angleColours[k])}${name} <output id="now-${name}"></output></span>`).join(""));
  const lines = [
    ...setPoints.map((values) => ({ values, colour: "--ink", dash: [4, 7], step: true })),
    ...angles.map((values, k) => ({ values, colour: angleColours[k], name: ["r", "p", "y"][k] })),
    ...[3, 4, 5].flatMap(referenceLines),
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

const tension = chart(byId("tension-chart"), run, {
  label: "Tensions of the cables over time", height: 270, range: tensionRange([run]), lines: tensionLines(run),
  limits: limitsOf(run), kept: keptOf(run), scrub: seek,
});
const marginHead = chartWithHead(byId("margin-chart"),
  `<b>smallest (N)</b><span>${swatch("line", "--p")}predicted from now on <output id="now-margin"></output></span><span>${swatch("dotted", "--soft")}now <output id="now-smallest"></output></span>`);
const smallest = smallestOf(run);
const [marginLow, marginHigh] = rangeOf([rows.margin, smallest, [0]], 1);
const margin = chart(marginHead.box, run, {
  label: "Margin and smallest tension over time", height: 150, range: [Math.max(marginLow, -marginHigh), marginHigh], last: true, limits: [run.limits.min], kept: keptOf(run).slice(0, 1), scrub: seek,
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
  const state = rows.status ? run.statuses[rows.status[row] - 1] ?? `unknown status ${rows.status[row]}` : "";
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
  moved(time, `smallest tension ${newtons(smallest[row])} newtons`);
}

for (const { row: at } of run.manySetPoints ? [] : run.setPoints.slice(1)) mark("step", rows.time[at], rows.time[at]);
for (const [from, to] of run.disturbedSpans) mark("disturbed-span", from, to);
for (const [from, to] of run.slackSpans) mark("slack-span", from, to);
for (const { from, to } of run.stateSpans) mark("state-span", from, to);
for (const at of run.faults) mark("fault", at, at);

// Paper is white, whatever the screen is.
for (const query of ["(prefers-color-scheme: dark)", "print"]) {
  matchMedia(query).addEventListener("change", () => [...positions, tension, margin].forEach((panel) => panel.redraw()));
}
show(0);
