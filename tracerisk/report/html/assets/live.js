// Looks once a second whether a file has changed, and loads the page again if so.
let known = null;
async function look() {
  if (document.hidden) return;
  try {
    const { state } = await (await fetch("/state")).json();
    if (state === undefined) return;
    if (known !== null && state !== known) location.reload();
    known = state;
  } catch {
    // The server has ended, or is not yet back: the page stays as it is.
  }
}
look();
setInterval(look, 1000);
