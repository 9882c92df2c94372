#! id: py_static_class_method
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
class Tool:
    @staticmethod
    def two(x):
        return 2 * x
    @property
    def wide(self):
        return self.width * 10
t = new Tool at 10 @ 0
param a = t.two(4), b = t.wide
