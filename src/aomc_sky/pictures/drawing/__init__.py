"""How a picture is drawn.

dome    One dome on one pair of axes: exact patches, rings and directions around them, marks
lines   Lines of text that fit into a picture, by the widths that its dots give the letters
panels  A whole figure: domes side by side, one colour bar, the title above, the key and the conventions below
style   How pictures look: sizes, colours, scales and their ticks
"""
