// Time: the bar at the bottom, its keys, and what every page says numbers with.

const byId = (id) => document.getElementById(id);
const COORDINATES = ["x", "y", "z"];
const metres = (value) => (Math.abs(value) < 5e-5 ? 0 : value).toFixed(4);
const newtons = (value) => (value === null ? "–" : (Math.abs(value) < 5e-4 ? 0 : value).toFixed(3));

/** Index of the time in the ascending list `times` that is nearest to `time`. */
function rowAt(times, time) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  return time - times[low] <= times[high] - time ? low : high;
}

/**
 * Lets people choose a time from `start` to `end`, of which `show(time)` is told. Gives {seek(time), mark(kind, from, to), moved(time, said), until(end)}:
 * a place on the slider from one time to another; what the slider and the clock say; another end.
 */
function transport(start, end, show) {
  const slider = byId("time"), calm = matchMedia("(prefers-reduced-motion: reduce)");
  let playing = null, now = start;

  /** Where someone pointed or stepped to; playing stops. */
  function seek(time) {
    stop();
    now = Math.min(end, Math.max(start, time));
    show(now);
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
      show(now);
    }
    if (now >= end) stop(); else requestAnimationFrame(frame);
  }

  const toggle = () => (playing === null ? play() : stop());
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

  function mark(kind, from, to) {
    const share = (time) => (100 * (time - start)) / (Number(slider.max) - start);
    const line = byId("marks").appendChild(document.createElement("i"));
    line.className = kind;
    line.style.left = `${share(from)}%`;
    if (to > from) line.style.width = `${share(to) - share(from)}%`;
  }

  function moved(time, said) {
    slider.value = time;
    slider.setAttribute("aria-valuetext", `${time.toFixed(3)} seconds, ${said}`);
    byId("clock").innerHTML = `<b>${time.toFixed(3)}</b> s <span>of ${end.toFixed(2)} s</span>`;
  }

  function until(last) {
    end = last;
    slider.min = start;
    slider.max = end > start ? end : start + 1;
  }
  until(end);
  return { seek, mark, moved, until };
}
