"""Tools that draw: style, colours, sizes, labels, legends; they know no recording."""
