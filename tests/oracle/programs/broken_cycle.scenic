#! id: broken_cycle
#! kind: error
#! tags: properties that depend on each other
class Knot:
    width: self.length
    length: self.width
ego = new Knot
