#! id: defaults_that_depend
#! kind: static
#! n: 900; props: load,width,length
class Cart:
    load: DiscreteRange(1, 3)
    width: 1 + self.load / 2
    length: 2 * self.width
    label[final]: "cart"
    requireVisible: False
class Truck(Cart):
    load: Uniform(4, 8)
    speed: 10 / self.load
ego = new Truck at 0 @ 0, facing 45 deg
c = new Cart left of ego by Range(1, 2)
t = new Truck at 40 @ 0, with load 5
param sizes = (ego.width, c.length, t.speed)
