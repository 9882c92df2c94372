#! id: broken_bare_self
#! kind: error
#! tags: self in a default
class A:
    x: self
ego = new A at 0 @ 0
