#! id: py_class_methods2
#! kind: static; tags: python
#! n: 2; props: size
ego = new Object at 0 @ 0
class Box:
    size: 4
    kind = 'box'
    def area(self, k=1):
        return self.size * self.size * k
    def grow(self):
        return self.area() + 1
class Big(Box):
    size: 10
    def area(self, k=1):
        return super().area(k) + 1000
b = new Big at 10 @ 0
c = new Box at 20 @ 0, with size 2
param a = b.area(), d = b.grow(), e = c.area(3), f = b.kind, g = isinstance(b, Box), h = Box.kind
