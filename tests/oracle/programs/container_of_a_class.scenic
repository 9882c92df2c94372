#! id: container_of_a_class
#! kind: static
#! tags: regionContainedIn as class default
#! n: 500
class Car:
    regionContainedIn: RectangularRegion(0 @ 0, 0, 30, 8)
    width: Range(1, 2)
ego = new Car at Range(-20, 0) @ Range(-5, 5)
b = new Car at Range(0, 20) @ Range(-5, 5), facing 90 deg, with length 5
