"""The chapters of the manual: classes, distributions, specifiers, Scenic's operators, requirements, regions, fields."""
