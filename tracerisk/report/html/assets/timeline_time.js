// What happens when, and the controls that move the one clock.

const MOVING = 1;
const HOLDING = 2;
const GRASPING = 4;
const BORDERLINE = 8;
const SOMEWHEN = 16;
const NO_COMPONENT = "that the hardware data has no figure for";

// Flat numbers (start [ms], length [ms], state) as objects, in [s].
function unpackSegments(flat) {
  const found = [];
  for (let i = 0; i < flat.length; i += 3) {
    found.push({
      start: flat[i] / 1000,
      stop: (flat[i] + flat[i + 1]) / 1000,
      state: flat[i + 2],
    });
  }
  return found;
}

// A run as `timeline_data` writes it, and what can be asked of it.
function openRun(run) {
  for (const row of run.rows) {
    row.segments = unpackSegments(row.segments);
    for (const element of row.elements) element.segments = unpackSegments(element.segments);
  }

  // Stretches of visits in the order of time: one visit may be current again after another.
  const stretches = run.visits
    .flatMap(({ spans }, visit) => spans.map(([start, stop]) => ({ visit, start, stop })))
    .sort((one, other) => one.start - other.start);

  // The last entry that begins at or before a time, if the time is in it.
  function at(entries, time) {
    let [low, high] = [0, entries.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (entries[middle].start <= time + 1e-9) low = middle + 1;
      else high = middle;
    }
    const found = entries[low - 1];
    return found && (time < found.stop - 1e-9 || found.stop >= run.end - 1e-9) ? found : null;
  }

  const componentOf = new Map(
    run.rows.flatMap(({ component, elements }) => elements.map(({ name }) => [name, component])),
  );
  return {
    run, stretches, at, componentOf,
    visitAt: (time) => at(stretches, time)?.visit ?? -1,
    // What to call a time in no visit.
    betweenVisits(time) {
      const next = stretches.find(({ start }) => start > time);
      return next ? `before ${run.functions[run.visits[next.visit].function]}` : "after the last visit";
    },
    functionOf: (visit) => run.functions[run.visits[visit].function],
    // The elements in use, by component: [{component, always, elements: [{name, state}]}].
    activeAt(time) {
      const found = [];
      for (const row of run.rows) {
        const elements = row.elements
          .map(({ name, segments }) => ({ name, state: at(segments, time)?.state ?? 0 }))
          .filter(({ state }) => state);
        if (row.always || elements.length) {
          found.push({ component: row.component, always: row.always, elements });
        }
      }
      return found;
    },
    contactsAt: (time) =>
      run.visits.flatMap(({ contacts }) =>
        contacts.filter(({ start, stop }) => start <= time && time <= stop),
      ),
  };
}

const { clock } = tracerisk;
const shownRun = openRun(tracerisk.data("timeline-data"));
const { run, stretches, at, visitAt, betweenVisits, functionOf, activeAt, contactsAt } = shownRun;
clock.setEnd(Math.max(run.end, clock.end));

const secondsText = (time) => `${time.toFixed(2)} s`;

function stateWords(state) {
  const words = [];
  if (state & MOVING) words.push("moving");
  if (state & HOLDING) words.push("holding");
  if (state & GRASPING) words.push("grasping");
  if (!words.length) words.push("in use");
  if (state & SOMEWHEN) words.push("some time in this visit");
  if (state & BORDERLINE) words.push("borderline");
  return words.join(", ");
}

// The active components in one sentence: "electric_motor: 3 moving, 4 holding; gripper: grasping".
function activeText(time) {
  const parts = activeAt(time)
    .filter(({ always, component }) => !always && component)
    .map(({ component, elements }) => {
      const counts = new Map();
      for (const { state } of elements) {
        const words = stateWords(state & ~BORDERLINE);
        counts.set(words, (counts.get(words) ?? 0) + 1);
      }
      const counted = [...counts].map(([words, n]) => (elements.length > 1 ? `${n} ${words}` : words));
      return `${component}: ${counted.join(", ")}`;
    });
  return parts.length ? parts.join("; ") : "nothing is active";
}

function placeText(time) {
  const visit = visitAt(time);
  if (visit < 0) return `${secondsText(time)}, ${betweenVisits(time)}`;
  return `${secondsText(time)}, ${functionOf(visit)}, visit ${visit + 1} of ${run.visits.length}`;
}

function stepVisit(forward) {
  const starts = stretches.map(({ start }) => start);
  const now = clock.time;
  const wanted = forward
    ? starts.find((start) => start > now + 1e-6)
    : starts.findLast((start) => start < now - 1e-6);
  clock.set(wanted ?? (forward ? run.end : 0), "visit");
}

// Plays a clock; `speed` returns how many times as fast as it ran.
function makePlayer(clock, speed) {
  let last = null;
  const listeners = new Set();
  const frame = (now) => {
    if (last === null) return;
    // After a pause of the page (a hidden tab) it goes on from where it was.
    const passed = Math.min((now - last) / 1000, 0.25);
    last = now;
    clock.set(clock.time + passed * speed(), "play");
    if (clock.time >= clock.end) player.pause();
    else requestAnimationFrame(frame);
  };
  const player = {
    get isPlaying() {
      return last !== null;
    },
    play() {
      if (last !== null) return;
      if (clock.time >= clock.end) clock.set(0, "play");
      last = performance.now();
      requestAnimationFrame(frame);
      for (const listener of listeners) listener(true);
    },
    pause() {
      if (last === null) return;
      last = null;
      for (const listener of listeners) listener(false);
    },
    toggle() {
      if (player.isPlaying) player.pause();
      else player.play();
    },
    onChange: (listener) => listeners.add(listener),
  };
  return player;
}

// A button that plays and pauses; it shows which of the two it does.
function playButton(button, player, what = "") {
  button.addEventListener("click", () => player.toggle());
  player.onChange((isPlaying) => {
    const word = `${isPlaying ? "Pause" : "Play"}${what}`;
    const shape = isPlaying ? "M4 3h3v10h-3zM9 3h3v10h-3z" : "M4 2.5v11l9-5.5z";
    button.querySelector("path").setAttribute("d", shape);
    button.setAttribute("aria-label", word);
    button.title = word;
  });
}

const player = makePlayer(clock, () => Number(document.getElementById("timeline-speed").value));

// Keys that move a clock: `step` goes to the next place, or back; true when one was taken.
const timeKeys = ({ clock, player, step }) => (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  if (event.key === " ") player.toggle();
  else if (event.key === "PageDown") step(true);
  else if (event.key === "PageUp") step(false);
  else if (event.key === "Home") clock.set(0, "keyboard");
  else if (event.key === "End") clock.set(clock.end, "keyboard");
  else return false;
  event.preventDefault();
  return true;
};
const timeKey = timeKeys({ clock, player, step: stepVisit });

function beginControls() {
  const slider = document.getElementById("timeline-slider");
  const shown = document.querySelector(".timeline-clock");
  const live = document.getElementById("timeline-live");
  const play = document.querySelector('[data-time="play"]');
  slider.max = String(clock.end);
  slider.addEventListener("input", () => {
    player.pause();
    clock.set(Number(slider.value), "slider");
  });
  document.querySelector('[data-time="previous"]').addEventListener("click", () => stepVisit(false));
  document.querySelector('[data-time="next"]').addEventListener("click", () => stepVisit(true));
  playButton(play, player);
  for (const jump of document.querySelectorAll("[data-time-at]")) {
    jump.addEventListener("click", () => {
      player.pause();
      clock.set(Number(jump.dataset.timeAt), "mark");
      document.getElementById("timeline").scrollIntoView();
    });
  }
  // Spoken at most once a second, and while it plays only when another visit begins.
  let waiting = null;
  let spokenVisit = -1;
  const speak = () => {
    waiting = null;
    spokenVisit = visitAt(clock.time);
    live.textContent = `${placeText(clock.time)}: ${activeText(clock.time)}`;
  };
  clock.subscribe((time, source) => {
    if (source !== "slider") slider.value = String(time);
    slider.setAttribute("aria-valuetext", placeText(time));
    shown.textContent = `${secondsText(time)} of ${secondsText(clock.end)}`;
    const isNews = source !== "play" || visitAt(time) !== spokenVisit;
    if (source !== null && isNews && waiting === null) waiting = setTimeout(speak, 1000);
  });
}
beginControls();
Object.assign(tracerisk, { player, makePlayer, playButton, timeKeys, openRun, shownRun, secondsText });
