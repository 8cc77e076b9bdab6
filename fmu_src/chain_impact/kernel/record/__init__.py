"""The one record that holds everything of a running simulation: a function for the layout of each part."""
