// Names beside what they name, and what the colours of the arm mean.

// Labels that would lie on one another are moved down until they do not.
function placeLabels(labels, wanted, view, canvas) {
  labels.replaceChildren();
  const placed = [];
  for (const { text, point, kind } of wanted) {
    const place = view && inClip(view, point);
    if (!place || Math.abs(place[0]) > 1 || Math.abs(place[1]) > 1) continue;
    const x = (place[0] * 0.5 + 0.5) * canvas.clientWidth;
    placed.push({ text, kind, x, y: (0.5 - place[1] * 0.5) * canvas.clientHeight });
  }
  placed.sort((one, other) => one.y - other.y);
  placed.forEach((each, i) => {
    const wide = each.text.length * 6.5;
    for (const above of placed.slice(0, i)) {
      const isBeside = Math.abs(above.x - each.x) > (wide + above.text.length * 6.5) / 2;
      if (!isBeside && each.y - above.y < 20) each.y = above.y + 20;
    }
    const span = document.createElement("span");
    span.className = `replay-label ${each.kind}`;
    span.textContent = each.text;
    span.style.left = `${each.x}px`;
    span.style.top = `${each.y}px`;
    labels.append(span);
  });
}

// The scale of the shares and how much of the risk lies behind the cursor, or the keys of states.
// `time` is `null` for the whole mission.
function showLegend(stage, risk, time) {
  const legend = stage.querySelector(".replay-legend");
  if (!legend) return;
  legend.hidden = false;
  const line = (kind, ...content) => {
    const row = document.createElement("p");
    row.className = kind;
    row.append(...content);
    return row;
  };
  const key = (kind) => {
    const span = document.createElement("span");
    span.className = `timeline-key is-${kind}`;
    span.setAttribute("aria-hidden", "true");
    return span;
  };
  if (!risk) {
    const keys = ["moving", "holding", "grasping"].flatMap((kind) => [key(kind), ` ${kind}  `]);
    legend.replaceChildren(line("replay-scale", ...keys));
    return;
  }
  const ramp = document.createElement("span");
  ramp.className = "replay-ramp";
  ramp.setAttribute("aria-hidden", "true");
  const so = time === null
    ? "whole mission"
    : `${percentText(risk.soFar(time))} of it by ${secondsText(time)}`;
  const rest = [...risk.elsewhere].filter(([, share]) => share > 0)
    .map(([name, share]) => `${name} ${percentText(share)}`);
  legend.replaceChildren(
    line("replay-scale", "0 ", ramp, ` ${percentText(risk.most)}`),
    line("", "of the mission\u2019s failure probability; ", so),
    ...(rest.length ? [line("", `Not on the arm: ${rest.join(", ")}`)] : []),
  );
}
