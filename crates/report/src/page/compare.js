// Two runs at one time: each in a column of its own, and both over one another.

const runs = JSON.parse(byId("run").textContent);
const LETTERS = ["a", "b"], COLOURS = ["--c1", "--c5"];
const start = Math.min(...runs.map((run) => run.rows.time[0]));
const ends = runs.map((run) => run.end);
let end = Math.max(...ends);
const { seek, moved, until } = transport(start, end, show);
const axis = { last: true, scrub: seek, ends: () => [start, end > start ? end : start + 1] };

// ---- panels, a column a run

const planes = runs.map((run, i) => plane(byId(`plane-${LETTERS[i]}`), run, runs));
const tensions = runs.map((run, i) => chart(byId(`tension-chart-${LETTERS[i]}`), run, {
  ...axis, label: `Tensions of run ${LETTERS[i].toUpperCase()} over time`, height: 270, range: tensionRange(runs), lines: tensionLines(run), limits: limitsOf(run), kept: keptOf(run),
}));

// ---- both over one another

const times = [...new Set(runs.flatMap((run) => run.rows.time))].sort((a, b) => a - b);
const both = { rows: { time: times }, disturbedSpans: [], stateSpans: [], unmeasuredSpans: [], faults: [], end, slackSpans: runs.flatMap((run) => run.slackSpans) };

/** A column of a run at all times of both: `step`s stay until the next, others go straight; nothing before the run and after it. */
function joined({ rows: { time } }, column, step) {
  let k = 0;
  return times.map((at) => {
    if (at < time[0] || at > time.at(-1)) return null;
    while (k + 1 < time.length && time[k + 1] <= at) k++;
    if (step || time[k] === at) return column[k];
    return column[k] + ((column[k + 1] - column[k]) * (at - time[k])) / (time[k + 1] - time[k]);
  });
}

/** A chart of `column(run)` of both, and their values at the time shown. */
function overlaid(parent, { name, id, unit, digits, column, more = () => [], height, last, limits }) {
  const columns = runs.map(column);
  const { box, outputs } = chartWithHead(byId(parent), `<b>${name} (${unit})</b>` + LETTERS.map((letter, i) =>
    `<span>${swatch("line", COLOURS[i])}${letter.toUpperCase()} <output id="now-${id}-${letter}"></output></span>`).join(""));
  const lines = runs.flatMap((run, i) => [
    ...more(run).map((values) => ({ values: joined(run, values, true), colour: COLOURS[i], dash: [5, 4], step: true })),
    { values: joined(run, columns[i]), colour: COLOURS[i], name: LETTERS[i].toUpperCase() },
  ]);
  const drawn = chart(box, both, {
    ...axis, last, label: `${name} of both runs over time`, height, range: rangeOf([...columns, ...runs.flatMap(more)], digits === 4 ? 0.02 : 1), lines, limits,
  });
  const say = (at) => outputs.forEach((output, i) => { output.textContent = columns[i][at[i]].toFixed(digits); });
  return { ...drawn, say };
}

const overlays = [
  ...COORDINATES.map((name, k) => overlaid("positions-charts", {
    name, id: name, unit: "m", digits: 4, column: (run) => run.rows.pose[k], more: (run) => [setPointColumn(run, k)], height: k === 2 ? 186 : 152, last: k === 2,
  })),
  overlaid("smallest-chart", { name: "smallest tension", id: "smallest", unit: "N", digits: 3, column: smallestOf, height: 420, last: true, limits: [...new Set(runs.map((run) => run.limits.min))] }),
];

// ---- time

/** A run that has ended stays as it was. */
function show(time) {
  const at = runs.map((run) => rowAt(run.rows.time, time));
  planes.forEach((view, i) => view.show(at[i]));
  tensions.forEach((drawn, i) => drawn.show(at[i]));
  overlays.forEach((drawn) => { drawn.show(rowAt(times, time)); drawn.say(at); });
  runs.forEach((run, i) => { byId(`now-${LETTERS[i]}`).innerHTML = described(run, at[i]); });
  moved(time, "both runs");
}

function described(run, row) {
  const at = COORDINATES.map((_, k) => metres(run.rows.pose[k][row])).join(", ");
  const slack = run.anchors.flatMap((_, i) => (isSlack(run, row, i) ? [i + 1] : []));
  const state = run.rows.status ? ` · ${run.statuses[run.rows.status[row] - 1] ?? `unknown status ${run.rows.status[row]}`}` : "";
  return `<b>(${at}) m</b>${state} · ${slack.length ? `<span class="bad">slack: cable ${slack.join(", ")}</span>` : "all cables taut"}`;
}

const redraw = () => [...tensions, ...overlays].forEach((drawn) => drawn.redraw());

/** The longer run leaves little room to the shorter: that part of time alone, and back. */
const zoom = byId("zoom"), whole = end, shorter = Math.min(...ends);
zoom.hidden = shorter <= start || shorter === whole;
zoom.textContent = `Only the first ${(shorter - start).toFixed(2)} s, while both run`;
zoom.addEventListener("click", () => {
  const on = zoom.getAttribute("aria-pressed") !== "true";
  zoom.setAttribute("aria-pressed", String(on));
  end = on ? shorter : whole;
  until(end);
  seek(Math.min(Number(byId("time").value), end));
  redraw();
});

// Paper is white, whatever the screen is.
for (const query of ["(prefers-color-scheme: dark)", "print"]) matchMedia(query).addEventListener("change", redraw);
show(start);
