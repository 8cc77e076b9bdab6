// Functions that find or make elements of the page.

/** Return the element of the page with an id; null if there is none. */
export function byId(id) {
  return document.getElementById(id);
}

/** Return a new element with some properties and children. */
export function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}
