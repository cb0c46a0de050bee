// What the two pictures share, and the robot in three dimensions: lines projected by hand, so that it needs neither WebGL nor a library.

/** An SVG element inside `parent`. */
function shape(parent, tag, attributes = {}, text) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  set(element, attributes);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
}

function set(element, attributes) {
  for (const name in attributes) element.setAttribute(name, attributes[name]);
}

/** A path through points [x, y]; an empty one where a point is not finite. */
function pathOf(points, closed) {
  if (!points.length || points.some((p) => !Number.isFinite(p[0] + p[1]))) return "";
  return "M" + points.map((p) => p[0].toFixed(1) + " " + p[1].toFixed(1)).join("L") + (closed ? "Z" : "");
}

/** An empty SVG that fills `box`, and `draw(svg, width, height)` again whenever its size changes, but not into a box that has no room yet. */
function canvas(box, draw) {
  const svg = shape(box, "svg", { "aria-hidden": "true" });
  new ResizeObserver(() => {
    svg.replaceChildren();
    set(svg, { viewBox: `0 0 ${box.clientWidth} ${box.clientHeight}` });
    if (Math.min(box.clientWidth, box.clientHeight) > 60) draw(svg, box.clientWidth, box.clientHeight);
  }).observe(box);
}

/** The last entry of `list` that holds at `row`. */
function activeAt(list, row) {
  let k = list.length - 1;
  while (k > 0 && list[k].row > row) k--;
  return k;
}

/** Whether cable `i`, from 0, is slack. */
function isSlack(run, row, i) {
  return ((run.rows.slack[row] >> i) & 1) === 1;
}

/** The platform's frame in that of the base: R = Rz(yaw) Ry(pitch) Rx(roll). */
function place(pose, [x, y, z]) {
  const [sr, sp, sw] = pose.slice(3).map(Math.sin), [cr, cp, cw] = pose.slice(3).map(Math.cos);
  return [
    pose[0] + cw * cp * x + (cw * sp * sr - sw * cr) * y + (cw * sp * cr + sw * sr) * z,
    pose[1] + sw * cp * x + (sw * sp * sr + cw * cr) * y + (sw * sp * cr - cw * sr) * z,
    pose[2] - sp * x + cp * sr * y + cp * cr * z,
  ];
}

const poseAt = (run, row) => run.rows.pose.map((column) => column[row]);

/** Points without repetitions, in order round their middle. */
function outline(points) {
  const apart = points.filter((p, i) => points.findIndex((q) => Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < 1e-6) === i);
  return apart.sort((p, q) => Math.atan2(p[1], p[0]) - Math.atan2(q[1], q[0]));
}

/** Draws the robot into `box`; gives `show(row)`, which moves it, and `reset()`. */
function scene(box, run) {
  const START = [-0.57, 0.36], { rows } = run;
  let [azimuth, elevation] = START;
  let parts = null, row = 0, size = [1, 1];
  const base = outline(run.anchors), platform = outline(run.attachments);
  const mean = (k) => run.anchors.reduce((sum, a) => sum + a[k], 0) / run.anchors.length, [midX, midY] = [mean(0), mean(1)];
  // Everything is drawn with z down: a rig with z up is turned by half a turn about x.
  const flip = run.zUp ? -1 : 1;
  const downs = [...run.anchors.map((a) => a[2]), ...rows.pose[2], ...run.setPoints.map((s) => s.pose[2])].map((z) => flip * z);
  const top = Math.min(...downs), depth = Math.max(...downs) - top + 0.05 * Math.max(...downs.map((z) => z - top));
  const wide = Math.max(...[...run.anchors, ...rows.pose[0].map((x, k) => [x, rows.pose[1][k]])].map((a) => Math.hypot(a[0] - midX, a[1] - midY)));
  // A sphere round everything: it fits into the picture from wherever one looks.
  const size3 = Math.max(...run.attachments.map((a) => Math.hypot(...a)));
  const centres = [...rows.pose[0].map((_, k) => poseAt(run, k)), ...run.setPoints.map((s) => s.pose)];
  const sections = run.sections.map(({ height, outline }) => outline.map(([x, y]) => [x, y, height]));
  const distance = (p) => Math.hypot(p[0] - midX, p[1] - midY, flip * p[2] - top - depth / 2);
  const radius = Math.max(...[...run.anchors, ...sections.flat()].map(distance), ...centres.map((p) => distance(p) + size3));
  const far = 4 * (wide + depth) + radius;
  const way = rows.time.map((_, k) => k).filter((k, _, all) => k % Math.ceil(all.length / 250) === 0);

  /** Perspective from afar, as large as the box allows; x to the right, z down and so y towards the reader at azimuth and elevation 0. */
  function project(point) {
    const [x, y, z] = [point[0] - midX, flip * (point[1] - midY), flip * point[2] - top];
    const [s, c] = [Math.sin(azimuth), Math.cos(azimuth)], [se, ce] = [Math.sin(elevation), Math.cos(elevation)];
    const across = c * x - s * y, away = -s * x - c * y, down = z - depth / 2;
    const scale = (0.48 * Math.min(...size) / radius) * (far - radius) / (far + away * ce + down * se);
    return [size[0] / 2 + across * scale, size[1] / 2 + (down * ce - away * se) * scale];
  }

  function draw(svg, width, height) {
    size = [width, height];
    parts = { base: shape(svg, "path", { class: "base" }), hexagon: shape(svg, "path", { class: "hexagon" }) };
    parts.sections = sections.map(() => shape(svg, "path", { class: "section" }));
    parts.axes = ["x", "y", "z"].map((name) => [shape(svg, "path", { class: "axis" }), shape(svg, "text", { class: "soft" }, name)]);
    parts.ahead = shape(svg, "path", { class: "path ahead" });
    parts.path = shape(svg, "path", { class: "path" });
    parts.goal = shape(svg, "path", { class: "ghost goal" });
    parts.setPoint = shape(svg, "path", { class: "ghost set-point" });
    parts.force = shape(svg, "path", { class: "force" });
    parts.p = shape(svg, "circle", { class: "p", r: 5 });
    parts.cables = run.anchors.map(() => shape(svg, "path"));
    parts.platform = shape(svg, "path", { class: "platform" });
    parts.centre = shape(svg, "circle", { class: "centre", r: 4 });
    parts.anchors = base.map(() => shape(svg, "circle", { class: "anchor", r: 4 }));
    parts.numbers = run.anchors.map((_, i) => shape(svg, "text", { class: "strong", "text-anchor": "middle", dy: "0.35em" }, i + 1));
    turn();
  }

  /** After a change of size or view: all that stands still. */
  function turn() {
    if (!parts) return;
    set(parts.base, { d: pathOf(base.map(project), true) });
    set(parts.hexagon, { d: pathOf(run.workspace.outline.map(([x, y]) => project([x, y, run.workspace.height])), true) });
    sections.forEach((outline, k) => set(parts.sections[k], { d: pathOf(outline.map(project), true) }));
    base.forEach((anchor, k) => { const [cx, cy] = project(anchor); set(parts.anchors[k], { cx, cy }); });
    [0, 1, 2].map((k) => [0, 1, 2].map((i) => (i === k ? 0.23 * wide : 0))).forEach((end, k) => {
      const [from, to] = [project([0, 0, 0]), project(end)], [line, name] = parts.axes[k];
      set(line, { d: pathOf([from, to]) });
      set(name, { x: to[0] + 4, y: to[1] + 4 });
    });
    set(parts.ahead, { d: pathOf(way.map((k) => project(poseAt(run, k)))) });
    move();
  }

  /** After a change of time as well: all that moves. */
  function move() {
    const pose = poseAt(run, row), centre = project(pose);
    const body = (at) => pathOf(platform.map((b) => project(place(at, b))), true);
    set(parts.platform, { d: body(pose) });
    set(parts.centre, { cx: centre[0], cy: centre[1] });
    set(parts.setPoint, { d: body(run.setPoints[activeAt(run.setPoints, row)].pose) });
    set(parts.goal, { d: body(run.goals[activeAt(run.goals, row)].pose) });
    set(parts.path, { d: pathOf([...way.filter((k) => k < row), row].map((k) => project(poseAt(run, k)))) });
    const [px, py] = rows.p.map((column) => column[row]), p = px === null ? [] : project([px, py, 0]);
    set(parts.force, { d: px === null ? "" : pathOf([p, centre]) });
    set(parts.p, { cx: p[0] ?? 0, cy: p[1] ?? 0, visibility: px === null ? "hidden" : "visible" });
    parts.cables.forEach((cable, i) => {
      const [from, to] = [project(run.anchors[i]), project(place(pose, run.attachments[i]))];
      const slack = isSlack(run, row, i), share = Math.min(1, Math.max(0, rows.tension[i][row] / run.colourTop));
      set(cable, { d: pathOf([from, to]), class: slack ? "slack" : "cable" });
      cable.style.stroke = slack ? "" : `color-mix(in oklch increasing hue, var(--low) ${(100 - 100 * share).toFixed(1)}%, var(--high))`;
      cable.style.strokeWidth = slack ? "" : (1.4 + 3.2 * share).toFixed(2);
      set(parts.numbers[i], { x: 0.55 * from[0] + 0.45 * to[0], y: 0.55 * from[1] + 0.45 * to[1] });
      parts.numbers[i].style.fill = slack ? "var(--slack)" : "";
    });
  }

  function orbit(byAzimuth, byElevation) {
    azimuth += byAzimuth;
    elevation = Math.min(1.55, Math.max(-1.55, elevation + byElevation));
    turn();
  }

  let dragged = null;
  box.addEventListener("pointerdown", (event) => { dragged = [event.clientX, event.clientY]; box.setPointerCapture(event.pointerId); });
  box.addEventListener("pointermove", (event) => {
    if (!dragged) return;
    orbit(0.008 * (event.clientX - dragged[0]), 0.008 * (event.clientY - dragged[1]));
    dragged = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"]) box.addEventListener(end, () => { dragged = null; });
  box.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    orbit(...by);
  });

  canvas(box, draw);
  return {
    show(at) { row = at; if (parts) move(); },
    reset() { [azimuth, elevation] = START; turn(); },
  };
}
