// What scrolls sideways can be scrolled with the keyboard.
const wide = ".md-typeset__scrollwrap, .md-typeset pre > code, .md-typeset math[display=block]";
for (const event of ["load", "resize"]) {
  window.addEventListener(event, () => {
    for (const element of document.querySelectorAll(wide)) {
      element.tabIndex = element.scrollWidth > element.clientWidth ? 0 : -1;
    }
  });
}
