#! id: broken_super
#! kind: error
#! tags: unknown base class
class Car(Vehicle):
    width: 2
ego = new Car
