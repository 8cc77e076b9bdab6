// Elements of the page.

/** The element with an id. */
export function find(id) {
  return document.getElementById(id);
}

/** An element with some properties and children. */
export function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}
