"""Colours and markers of figures."""

# Okabe & Ito's palette, distinguishable with colour blindness; markers distinguish classes in greyscale.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
