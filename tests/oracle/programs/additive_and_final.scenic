#! id: additive_and_final
#! kind: static
#! tags: additive properties, methods with self
#! n: 20
class Base:
    size: 2
    def area(self):
        return self.size ** 2
class Big(Base):
    size: 5
ego = new Big
b = new Base at 9 @ 9
param a = ego.area() + b.area(), k = isinstance(ego, Base)
