"""The record that holds all data of a running simulation: a function for the layout of each part."""
