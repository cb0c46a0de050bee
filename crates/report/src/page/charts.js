// Curves over time, drawn by uPlot; the cursor is a line of our own, so that moving it draws nothing anew.

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/**
 * A chart in `box`. `lines`: {values, colour, dash, step, name}, a name is written at the line's end. `limits`: values of red lines, `kept`: of
 * fainter ones, within which a planner keeps. `ends()`: from when to when, if that is not the run's own. `scrub(time)` is called when a pointer presses or drags on it. Gives {show(row), focus(i), redraw()}.
 */
function chart(box, run, { label, height, range, lines, limits = [], kept = [], last, scrub, ends }) {
  const { time } = run.rows;
  const own = [time[0], run.end > time[0] ? run.end : time[0] + 1];
  const axis = { stroke: () => colour("--soft"), grid: { stroke: () => colour("--rule"), width: 1 }, ticks: { show: false }, font: "12px system-ui, sans-serif" };
  const plot = new uPlot({
    width: Math.max(200, box.clientWidth), height, padding: [limits.some((value) => value > range[1]) ? 18 : 8, 26, last ? 0 : 6, 0], cursor: { show: false }, select: { show: false },
    legend: { show: false }, focus: { alpha: 0.16 },
    scales: { x: { time: false, range: ends ?? (() => own) }, y: { range: () => range } },
    axes: [
      { ...axis, size: last ? 34 : 0, show: true, values: last ? (_, ticks) => ticks.map((t) => (t === ticks.at(-1) ? `${t} s` : t)) : () => [] },
      { ...axis, size: 48, space: 26 },
    ],
    series: [{}, ...lines.map((line) => ({
      stroke: () => colour(line.colour), width: line.dash ? 1.3 : 2.4, dash: line.dash, points: { show: false }, spanGaps: false,
      paths: line.step ? uPlot.paths.stepped({ align: 1 }) : uPlot.paths.linear(),
    }))],
    hooks: {
      drawClear: [
        (u) => run.stateSpans.forEach(({ state, from, to }) => spans(u, [[from, to]], stateColour(state) + "2e")),
        (u) => spans(u, run.disturbedSpans, colour("--soft") + "2e"), (u) => spans(u, run.slackSpans, colour("--slack") + "33"),
      ],
      draw: [(u) => unmeasured(u, run.unmeasuredSpans), (u) => states(u, run), (u) => kept.forEach((value) => keptLine(u, value)), (u) => limits.forEach((value) => limitLine(u, value)), (u) => names(u, lines), () => show(row)],
    },
  }, [time, ...lines.map((line) => line.values)], box);
  box.classList.add("chart");
  set(box, { role: "img", "aria-label": label });
  const cursor = document.createElement("div");
  cursor.className = "cursor";
  plot.over.append(cursor);
  let row = 0;
  const show = (at) => {
    row = at;
    cursor.style.transform = `translateX(${plot.valToPos(time[at], "x").toFixed(1)}px)`;
  };
  new ResizeObserver(() => plot.setSize({ width: Math.max(200, box.clientWidth), height })).observe(box);
  const point = (event) => scrub(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
  let pressed = false;
  plot.over.addEventListener("pointerdown", (event) => { pressed = true; plot.over.setPointerCapture(event.pointerId); point(event); });
  plot.over.addEventListener("pointermove", (event) => pressed && point(event));
  for (const end of ["pointerup", "pointercancel"]) plot.over.addEventListener(end, () => { pressed = false; });
  // Scales are found anew: `ends` may have changed.
  return { show, redraw: () => plot.setData(plot.data), focus: (i) => plot.setSeries(i === null ? null : i + 1, { focus: i !== null }) };
}

/** Background where a cable is slack, the platform is disturbed, or the bridge is in another state than Enabled. */
function spans(u, times, fill) {
  const { left, top, width, height } = u.bbox;
  u.ctx.save();
  u.ctx.fillStyle = fill;
  for (const [from, to] of times) {
    const [x0, x1] = [from, to].map((t) => Math.min(left + width, Math.max(left, u.valToPos(t, "x", true))));
    u.ctx.fillRect(x0, top, Math.max(2, x1 - x0), height);
  }
  u.ctx.restore();
}

const stateColour = (state) => colour(state === "Fault" ? "--fault" : state === "Stopping" ? "--low" : "--soft");

/** Names of the states at the top of their bands, where they fit, and lines where something was found wrong. */
function states(u, { stateSpans, faults }) {
  const { left, top, width, height } = u.bbox;
  const place = (t) => Math.min(left + width, Math.max(left, u.valToPos(t, "x", true)));
  u.ctx.save();
  u.ctx.font = `600 ${11.5 * devicePixelRatio}px system-ui, sans-serif`;
  u.ctx.textAlign = "left";
  u.ctx.textBaseline = "top";
  for (const { state, from, to } of stateSpans) {
    const gap = 4 * devicePixelRatio;
    if (u.ctx.measureText(state).width + 2 * gap > place(to) - place(from)) continue;
    u.ctx.fillStyle = stateColour(state);
    u.ctx.fillText(state, place(from) + gap, top + gap);
  }
  u.ctx.fillStyle = colour("--fault");
  for (const at of faults) u.ctx.fillRect(place(at) - devicePixelRatio, top, 2 * devicePixelRatio, height);
  u.ctx.restore();
}

/** Hatched, and over the lines: what they would be there, nobody knows. */
function unmeasured(u, times) {
  const { left, top, width, height } = u.bbox, gap = 7 * devicePixelRatio;
  for (const [from, to] of times) {
    const [x0, x1] = [from, to].map((t) => Math.min(left + width, Math.max(left, u.valToPos(t, "x", true))));
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(x0, top, x1 - x0, height);
    u.ctx.clip();
    u.ctx.globalAlpha = 0.75;
    u.ctx.fillStyle = colour("--card");
    u.ctx.fillRect(x0, top, x1 - x0, height);
    u.ctx.globalAlpha = 0.4;
    u.ctx.strokeStyle = colour("--soft");
    u.ctx.lineWidth = devicePixelRatio;
    u.ctx.beginPath();
    for (let x = x0 - height; x < x1; x += gap) { u.ctx.moveTo(x, top + height); u.ctx.lineTo(x + height, top); }
    u.ctx.stroke();
    u.ctx.restore();
  }
}

function limitLine(u, value) {
  if (u.valToPos(value, "y", true) < u.bbox.top - 1) limitNote(u, value);
  levelLine(u, value, 1.5, [10, 3, 2, 3]);
}

function keptLine(u, value) {
  levelLine(u, value, 1, [1, 3]);
}

/** A line across at a value within the axis. */
function levelLine(u, value, lineWidth, dash) {
  const y = u.valToPos(value, "y", true), { left, top, width, height } = u.bbox;
  if (y < top - 1 || y > top + height + 1) return;
  u.ctx.save();
  u.ctx.strokeStyle = colour("--slack");
  u.ctx.lineWidth = lineWidth * devicePixelRatio;
  u.ctx.setLineDash(dash.map((d) => d * devicePixelRatio));
  u.ctx.beginPath();
  u.ctx.moveTo(left, y);
  u.ctx.lineTo(left + width, y);
  u.ctx.stroke();
  u.ctx.restore();
}

/** A limit above the axis, told over its top rather than drawn: the curves would be flat. */
function limitNote(u, value) {
  const { left, top, width } = u.bbox;
  u.ctx.save();
  u.ctx.fillStyle = colour("--slack");
  u.ctx.font = `${11.5 * devicePixelRatio}px system-ui, sans-serif`;
  u.ctx.textAlign = "right";
  u.ctx.textBaseline = "bottom";
  u.ctx.fillText(`limit ${value} N ↑`, left + width, top - 3 * devicePixelRatio);
  u.ctx.restore();
}

/** Names at the right ends of the lines as far as they are drawn, moved apart. */
function names(u, lines) {
  const shown = u.data[0].findLastIndex((time) => time <= u.scales.x.max) + 1;
  const gap = 12 * devicePixelRatio, { left, top, width, height } = u.bbox;
  const labels = lines.filter((line) => line.name).map((line) => {
    const end = line.values.slice(0, shown).findLast((value) => value !== null) ?? 0;
    return { text: line.name, fill: colour(line.colour), y: u.valToPos(end, "y", true) };
  }).sort((a, b) => a.y - b.y);
  labels.forEach((label, k) => { if (k) label.y = Math.max(label.y, labels[k - 1].y + gap); });
  const over = Math.max(0, (labels.at(-1)?.y ?? 0) - (top + height));
  u.ctx.save();
  u.ctx.font = `600 ${11.5 * devicePixelRatio}px system-ui, sans-serif`;
  u.ctx.textAlign = "left";
  u.ctx.textBaseline = "middle";
  for (const { text, fill, y } of labels) {
    u.ctx.fillStyle = fill;
    u.ctx.fillText(text, left + width + 5 * devicePixelRatio, y - over);
  }
  u.ctx.restore();
}

/** From the least to the greatest of `columns`, at least `least` wide, with a little room. */
function rangeOf(columns, least) {
  const values = columns.flat().filter((value) => value !== null);
  const bound = (pick, start) => values.reduce((a, b) => pick(a, b), start);
  const [low, high] = [bound(Math.min, values[0] ?? 0), bound(Math.max, values[0] ?? 0)];
  const room = Math.max(0.08 * (high - low), (least - (high - low)) / 2, 1e-9);
  return [low - room, high + room];
}

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

/** A coordinate of the set point at each drawn row. */
function setPointColumn({ rows, setPoints }, k) {
  let active = 0;
  return rows.time.map((_, row) => {
    while (active + 1 < setPoints.length && setPoints[active + 1].row <= row) active++;
    return setPoints[active].pose[k];
  });
}

const smallestOf = ({ rows }) => rows.time.map((_, row) => Math.min(...rows.tension.map((column) => column[row])));

// ---- tensions

const tensionLines = (run) => [
  ...run.rows.tension.map((values, i) => ({ values, colour: `--c${(i % 6) + 1}`, name: `u${i + 1}` })),
  ...(run.rows.predicted ?? []).map((values) => ({ values, colour: "--ink", dash: [4, 7] })),
];

const limitsOf = (run) => [run.limits.min, run.limits.max].filter((value) => value !== null);
/** What the planner keeps of them, where it keeps anything. */
const keptOf = (run) => (run.limits.kept ? [run.limits.min + run.limits.kept, ...(run.limits.max === null ? [] : [run.limits.max - run.limits.kept])] : []);

/** Of the tensions of all `runs`; a limit that is near their greatest is within it. */
function tensionRange(runs) {
  const top = Math.max(...runs.map((run) => run.tensionTop));
  const near = runs.flatMap(limitsOf).filter((value) => value > top && value < 1.25 * top);
  const [low, high] = rangeOf([...runs.flatMap(({ rows }) => [...rows.tension, ...(rows.predicted ?? [])]), near], 1);
  return [Math.max(-0.4 * top, Math.min(low, -0.03 * top)), Math.min(high, 1.5 * top)];
}
