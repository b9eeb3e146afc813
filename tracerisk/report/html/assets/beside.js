// In a frame beside another run: both show the same instant.
const { clock } = tracerisk;
if (window.parent !== window) {
  clock.subscribe((time, source) => {
    if (source !== "beside") window.parent.postMessage({ tracerisk: "time", time }, "*");
  });
  addEventListener("message", (event) => {
    if (event.source === window.parent && event.data?.tracerisk === "time") {
      clock.set(event.data.time, "beside");
    }
  });
}
