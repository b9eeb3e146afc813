// Mouse, touch and keys that move the camera; `keys` takes those that move time.
function steer(canvas, camera, keys) {
  const pointers = new Map();
  const spread = () => {
    const [one, other] = [...pointers.values()];
    return Math.hypot(one.x - other.x, one.y - other.y);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const before = pointers.size === 2 ? spread() : 0;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const height = canvas.clientHeight;
    if (pointers.size === 2) {
      camera.zoom(before / Math.max(spread(), 1));
      camera.pan(dx / height / 2, dy / height / 2);
    } else if (event.shiftKey || event.buttons & 6) camera.pan(dx / height, dy / height);
    else camera.orbit((dx / height) * 3, (dy / height) * 3);
    camera.changed();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    // A page that is scrolled past the view must not be caught in it.
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    camera.zoom(Math.exp(event.deltaY * 0.0012));
    camera.changed();
  }, { passive: false });
  const moves = {
    ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12],
  };
  canvas.addEventListener("keydown", (event) => {
    if (keys(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    const move = moves[event.key];
    if (move && event.shiftKey) camera.pan(move[0] * 0.5, move[1] * 0.5);
    else if (move) camera.orbit(-move[0], move[1]);
    else if (event.key === "+" || event.key === "=") camera.zoom(1 / 1.15);
    else if (event.key === "-") camera.zoom(1.15);
    else if (event.key === "0") camera.reset();
    else return;
    event.preventDefault();
    camera.changed();
  });
}

// A label at what the pointer is on; a click without a drag chooses its component.
function hover(canvas, labels, find, text, choose) {
  const tip = document.createElement("span");
  tip.className = "replay-tip";
  tip.hidden = true;
  labels.parentElement.append(tip);
  let begun = null;
  const under = (event) => {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    return { x, y, body: find((x / box.width) * 2 - 1, 1 - (y / box.height) * 2) };
  };
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) {
      tip.hidden = true;
      return;
    }
    const { x, y, body } = under(event);
    tip.hidden = !body;
    if (!body) return;
    tip.textContent = text(body);
    tip.style.left = `${x + 14}px`;
    tip.style.top = `${y + 14}px`;
  });
  canvas.addEventListener("pointerleave", () => {
    tip.hidden = true;
  });
  canvas.addEventListener("pointerdown", (event) => {
    begun = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointerup", (event) => {
    const isClick = begun && Math.hypot(event.clientX - begun[0], event.clientY - begun[1]) < 4;
    begun = null;
    if (isClick && event.button === 0) choose(under(event).body);
  });
}
