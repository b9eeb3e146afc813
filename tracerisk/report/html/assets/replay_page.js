// The replay of this page: its run in the stage beside the headline.

const { componentOf } = shownRun;
const riskData = document.getElementById("replay-risk") ? tracerisk.data("replay-risk") : null;

// What a chosen component adds to the risk, and the blocks in the source that say so.
function showChosen(place, risk) {
  let element = null;
  document.addEventListener("tracerisk:select", ({ detail }) => {
    if (detail.source !== "replay") element = null;
    const { component } = detail;
    const rows = riskData.shares.filter(([, each]) => each === component);
    place.hidden = component === null || !rows.length;
    if (place.hidden) return;
    const sum = (list) => list.reduce((total, [, , , share]) => total + share, 0);
    const byFunction = new Map();
    for (const row of rows) byFunction.set(row[0], [...(byFunction.get(row[0]) ?? []), row]);
    const ranked = [...byFunction].sort((one, other) => sum(other[1]) - sum(one[1]));
    const links = ranked.map(([name, own]) => {
      const [target, where] = riskData.blocks[name] ?? [null, ""];
      const item = document.createElement(target ? "a" : "span");
      if (target) item.href = target;
      item.textContent = `${name} ${percentText(sum(own))}`;
      item.title = where;
      return item;
    });
    const name = document.createElement("b");
    name.textContent = component;
    const own = element ? `, of which ${element} ${percentText(risk.whole(element))}` : "";
    place.replaceChildren(
      name, `: ${percentText(sum(rows))} of the mission\u2019s failure probability${own}. In the source: `,
      ...links.flatMap((link, i) => (i ? [", ", link] : [link])),
    );
  });
  return (chosen) => {
    const component = componentOf.get(chosen) || null;
    // A second link of the same component is news too.
    if (component === tracerisk.selected.component) tracerisk.select({});
    element = chosen;
    tracerisk.select({ component, source: "replay" });
  };
}

async function beginReplay() {
  beginNow();
  const stage = document.querySelector(".replay-stage");
  const risk = riskData?.shares.length ? riskOverTime(riskData.shares) : null;
  const place = stage.closest(".replay").querySelector(".replay-chosen");
  const choose = risk
    ? showChosen(place, risk)
    : (element) => tracerisk.select({ component: componentOf.get(element) || null, source: "replay" });
  const { bodies, frames } = tracerisk.data("replay-bodies");
  const packed = tracerisk.bytes("replay-frames");
  const replay = await createReplay(stage, { bodies, frames, packed, activity: shownRun, risk, choose });
  if (replay) tracerisk.replay = Object.assign(replay, tracerisk.replay);
}

tracerisk.replay = { poses, touchPoint, create: createReplay };
tracerisk.replay.ready = beginReplay();
tracerisk.replay.ready.catch((problem) => {
  const message = document.querySelector(".replay-stage .replay-message");
  message.hidden = false;
  message.textContent = `The replay cannot be shown: ${problem.message}. The timeline works.`;
});
