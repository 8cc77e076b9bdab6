// Functions for elements of the page.

/** Return the element with an id. */
export function find(id) {
  return document.getElementById(id);
}

/** Return a new element with some properties and children. */
export function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}
