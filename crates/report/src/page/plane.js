// The base plane as seen from below (x to the right, y up): workspace, reachable domains, path, and p, which tells why a cable goes slack.

/** Draws the plane into `box`, as large as all `runs` that it is looked at beside allow; gives `show(row)`. */
function plane(box, run, runs = [run]) {
  const { rows } = run, MANY = 12;
  let parts = null, row = 0, at = null;

  /** Metres to pixels: the workspace, the path and what is near them, x and y alike. */
  function scaled(width, height) {
    const reach = run.apothem ? 2.2 * run.apothem : Infinity;
    const near = (v) => Math.max(-reach, Math.min(reach, v));
    const points = runs.flatMap(({ workspace, setPoints, goals }) => [...workspace.outline, ...setPoints.map((s) => s.pose), ...goals.map((g) => g.pose)]);
    const side = [0, 1].map((k) => {
      const ways = runs.flatMap((run) => [Math.min(...run.rows.pose[k]), Math.max(...run.rows.pose[k])]);
      const values = [...points.map((p) => p[k]), ...ways].map(near);
      return [Math.min(...values), Math.max(...values)];
    });
    const [[left, right], [bottom, top]] = side;
    const scale = Math.min((width - 56) / (right - left), (height - 56) / (top - bottom));
    return ([x, y]) => [width / 2 + (x - (left + right) / 2) * scale, height / 2 - (y - (bottom + top) / 2) * scale];
  }

  function draw(svg, width, height) {
    at = scaled(width, height);
    const line = (points, name, closed) => shape(svg, "path", { class: name, d: pathOf(points.map(at), closed) });
    parts = {};
    line(run.workspace.outline, "hexagon", true);
    parts.domains = run.setPoints.map((s) => (s.domain ? line(s.domain, "domain", true) : null));
    scaleBar(svg, width, height);
    const thin = rows.time.map((_, k) => k).filter((k, _, all) => k % Math.ceil(all.length / 600) === 0 || k === all.length - 1);
    parts.pJumps = shape(svg, "path", { class: "p-jump" });
    parts.pTrail = shape(svg, "path", { class: "p-trail" });
    parts.thin = thin;
    line(thin.map((k) => [rows.pose[0][k], rows.pose[1][k]]), "path ahead");
    parts.path = shape(svg, "path", { class: "path" });
    parts.reach = shape(svg, "path", { class: "reach-line" });
    parts.facet = shape(svg, "path", { class: "facet" });
    // Middles of the texts that stand still: the goal's name keeps clear of them.
    parts.written = [];
    run.normals.forEach((n, i) => {
      const [x, y] = at([n[0] * run.apothem, n[1] * run.apothem]);
      parts.written.push([x + 15 * n[0], y - 13 * n[1]]);
      shape(svg, "text", { class: "soft", x: x + 15 * n[0], y: y - 13 * n[1], "text-anchor": "middle", dy: "0.35em" }, i + 1);
    });
    parts.goal = shape(svg, "path", { class: "goal-mark" });
    parts.dots = run.manySetPoints ? setPointLine(svg) : setPointDots(svg);
    parts.goalName = shape(svg, "text", { "text-anchor": "middle" }, "goal");
    parts.centre = shape(svg, "circle", { class: "centre", r: 5 });
    parts.p = shape(svg, "circle", { class: "p", r: 5.5 });
    parts.pName = shape(svg, "text", { class: "strong" }, "p");
    move();
  }

  /** A line through all of them, and one dot at the active one. */
  function setPointLine(svg) {
    shape(svg, "path", { class: "set-point-line", d: pathOf(run.setPoints.map((s) => at(s.pose))) });
    return [shape(svg, "circle", { class: "set-point-dot active", r: 3.5 })];
  }

  /** Dots with numbers; a number that would stand on another one is left out. */
  function setPointDots(svg) {
    const { written } = parts;
    return run.setPoints.map((s, i) => {
      const [cx, cy] = at(s.pose);
      const label = [cx + (i % 2 ? 9 : -9), cy + (i % 2 ? 13 : -9)];
      if (written.every((w) => Math.hypot(w[0] - label[0] - (i % 2 ? 7 : -7), w[1] - label[1] + 4) > 13)) {
        shape(svg, "text", { x: label[0], y: label[1], "text-anchor": i % 2 ? "start" : "end" }, i);
        written.push([label[0] + (i % 2 ? 7 : -7), label[1] - 4]);
      }
      return shape(svg, "circle", { class: "set-point-dot", cx, cy, r: 3.5 });
    });
  }

  function scaleBar(svg, width, height) {
    const metre = at([1, 0])[0] - at([0, 0])[0];
    // A round length of at most 120 pixels.
    const ten = 10 ** Math.floor(Math.log10(120 / metre)), metres = [5, 2, 1].find((k) => k * ten * metre <= 120) * ten;
    const length = metres * metre;
    shape(svg, "path", { class: "axis", d: `M8 ${height - 10}v4h${length.toFixed(1)}v-4` });
    shape(svg, "text", { class: "soft", x: 8, y: height - 14 }, `${+metres.toPrecision(1)} m`);
    shape(svg, "path", { class: "axis", d: `M${width - 44} ${height - 10}h28m-5 -4l5 4l-5 4M${width - 44} ${height - 10}v-28m-4 5l4 -5l4 5` });
    shape(svg, "text", { class: "soft", x: width - 13, y: height - 6 }, "x");
    shape(svg, "text", { class: "soft", x: width - 48, y: height - 44 }, "y");
  }

  function move() {
    const active = activeAt(run.setPoints, row), pose = poseAt(run, row), centre = at(pose);
    parts.domains.forEach((domain, i) => {
      if (!domain) return;
      set(domain, { class: i === active ? "domain active" : "domain", visibility: i === active || parts.domains.length <= MANY ? "visible" : "hidden" });
    });
    if (run.manySetPoints) {
      const [cx, cy] = at(run.setPoints[active].pose);
      set(parts.dots[0], { cx, cy });
    } else {
      parts.dots.forEach((dot, i) => set(dot, { class: i === active ? "set-point-dot active" : "set-point-dot" }));
    }
    set(parts.centre, { cx: centre[0], cy: centre[1] });
    set(parts.path, { d: pathOf([...parts.thin.filter((k) => k < row), row].map((k) => at([rows.pose[0][k], rows.pose[1][k]]))) });
    const [gx, gy] = at(run.goals[activeAt(run.goals, row)].pose);
    set(parts.goal, { d: `M${gx - 7} ${gy - 7}l14 14m0 -14l-14 14` });
    nameGoal(gx, gy);
    trailP();
    moveP();
  }

  /** Where p was. It jumps with the tensions, and was nowhere between: only where it ran, or stood, is the line full. */
  function trailP() {
    const past = parts.thin.filter((k) => k <= row && rows.p[0][k] !== null).map((k) => [rows.p[0][k], rows.p[1][k]]);
    let ran = "", jumps = "";
    for (let k = 1; k < past.length; k++) {
      const piece = pathOf([past[k - 1], past[k]].map(at));
      if (Math.hypot(past[k][0] - past[k - 1][0], past[k][1] - past[k - 1][1]) > JUMP * run.apothem) jumps += piece; else ran += piece;
    }
    set(parts.pTrail, { d: ran });
    set(parts.pJumps, { d: jumps });
  }

  function moveP() {
    const near = nearestFacet(run, row);
    for (const name of ["p", "pName"]) set(parts[name], { visibility: near ? "visible" : "hidden" });
    for (const name of ["facet", "reach"]) set(parts[name], { visibility: near && !near.turned ? "visible" : "hidden" });
    if (!near) return;
    const [x, y] = at(near.p), n = run.normals[near.cable];
    set(parts.p, { cx: x, cy: y });
    nameP(x, y);
    set(parts.facet, { d: near.cables.map((i) => pathOf(run.facets[i].map(at))).join(""), class: near.distance <= 0 && near.slack ? "facet crossed" : "facet" });
    const foot = [near.p[0] + n[0] * near.distance, near.p[1] + n[1] * near.distance];
    set(parts.reach, { d: near.cables.length > 1 ? "" : pathOf([[x, y], at(foot)]) });
  }

  /** Beside the goal: the first place within the picture and clear of the numbers of the set points. */
  function nameGoal(x, y) {
    const isFree = ([dx, dy]) => x + dx > 16 && x + dx < box.clientWidth - 16 && y + dy > 12 && y + dy < box.clientHeight - 4
      && parts.written.every((w) => Math.abs(w[0] - x - dx) > 27 || Math.abs(w[1] - y - dy + 4) > 20);
    const [dx, dy] = [[0, 26], [0, -16], [30, 4], [-30, 4], [30, 30], [-30, -24], [0, 44], [0, -34]].find(isFree) ?? [0, 26];
    set(parts.goalName, { x: x + dx, y: y + dy });
  }

  /** Beside p: the first place within the picture and clear of the goal's name. */
  function nameP(x, y) {
    const name = { x: Number(parts.goalName.getAttribute("x")), y: Number(parts.goalName.getAttribute("y")) };
    const isFree = ([dx, dy]) => x + 2 * dx < box.clientWidth && (Math.abs(x + 1.5 * dx - name.x) > 22 || Math.abs(y + dy - name.y) > 18);
    const [dx, dy] = [[9, -8], [9, 18], [-9, -8], [-9, 18]].find(isFree) ?? [-9, -8];
    set(parts.pName, { x: x + dx, y: y + dy, "text-anchor": dx > 0 ? "start" : "end" });
  }

  canvas(box, draw);
  return { show(to) { row = to; if (parts) move(); } };
}

/** What p goes between two drawn rows is a jump if it is more than this, as a part of the distance of a facet from the middle. */
const JUMP = 0.2;
/** Turned by more than this, rad, the platform's facets are somewhere else. */
const LEVEL = 0.01;

/**
 * p, the facet it is nearest to (or farthest beyond) and those that are as near, how far inside it is, m, whether that facet's cable is slack and whether the
 * platform is turned, so that the facets do not tell; null where there is no p.
 */
function nearestFacet(run, row) {
  const p = run.rows.p.map((column) => column[row]);
  if (p[0] === null) return null;
  const distances = run.normals.map((n) => run.apothem - n[0] * p[0] - n[1] * p[1]);
  const distance = Math.min(...distances), cable = distances.indexOf(distance);
  const turned = run.rows.pose.slice(3).some((column) => Math.abs(column[row]) > LEVEL);
  // What rounding of the drawn rows makes of equals.
  const cables = distances.flatMap((d, i) => (d - distance < 2e-6 * Math.max(1, run.apothem) ? [i] : []));
  return { p, cable, cables, distance, turned, slack: isSlack(run, row, cable) };
}
