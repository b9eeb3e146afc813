"""The report as one HTML page that needs nothing else: no network, no fonts, no second file.

A page is made of sections (`section.py`); `page.py` puts them, the styles and the scripts into one
file. A `Section` has HTML that was escaped on the way (`markupsafe.Markup`), its own styles and
script, and data that the script reads; who makes one needs to know nothing of the others.

What a script finds in the page (`assets/core.js`):

- `tracerisk.data(id)` returns the JSON of a `Data` block, `tracerisk.bytes(id)` its bytes as a
  `Uint8Array`.
- `tracerisk.clock` is the one clock: `time` [s of the run], `end` [s], `set(time, source)`, held
  within `[0, end]`, and `subscribe(listener)`, which is called with `(time, source)` at once and
  at each change, and returns what ends it. `setEnd(end)` is for who knows how long the run was.
- `tracerisk.select({function, component, source})` chooses a function, a component, both or
  neither (`null`); `tracerisk.selected` is what is chosen. The event `tracerisk:select` on
  `document` has the same in its `detail`. Elements with `data-function` or `data-component` get
  the class `is-selected` when they fit what is chosen, and a click on a `<button>` with such an
  attribute chooses it, or nothing when it was chosen. Functions are named as in the model
  (`adder.model_names`), components as in the hardware description.
- The event `tracerisk:theme` on `document` says that colours changed: scripts that draw read them
  by `tracerisk.colour(name)` from the variables of `assets/page.css`.

The page forbids everything that it does not bring along (Content-Security-Policy): no `style`
attribute in HTML, no handler in an attribute, no `eval`; styles set through `element.style` and
SVG presentation attributes work. Each script runs as a function of its own, after the whole page
is there. On paper every `<details>` is unfolded but those with `data-print="folded"`.
"""
