#! id: classes_of_classes
#! kind: static
#! n: 600; props: size
class Base:
    size: Range(1, 2)
    requireVisible: False
class Child(Base):
    size: 3
kinds = [Base, Child]
made = [new cls at (6 * i) @ 0 for i, cls in enumerate(kinds)]
ego = made[0]
param derived = [issubclass(cls, Base) for cls in kinds][1], is_it = isinstance(ego, Child)
param total = sum([m.size for m in made])
