#! id: heading_from_class
#! kind: static
#! tags: heading defaults that read other properties
#! n: 300
class Car:
    position: 3 @ 4
    heading: 10 deg
    foo: self.position.x
class Truck(Car):
    heading: self.foo * 10 deg
ego = new Truck
b = new Car at 10 @ 10
c = new Truck at 20 @ 20, with foo 4
