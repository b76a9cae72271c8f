"""How a picture is drawn.

style   Colours, fonts, sizes, numbers beside the bar
dome    One dome: patches, rim, marks
panels  Several domes with their texts, colour bar and key
"""
