"""The thesis's benchmark made again: what is measured, kept as small tables, and the page that is drawn from them."""
