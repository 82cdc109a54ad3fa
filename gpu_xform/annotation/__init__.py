"""Annotation: text, and the lines and boxes that go with it, laid out in pixels and drawn over a picture.

Reading order: options, fonts, items, text_style, boxes, labels, ticks, axes, column, paint.
"""
