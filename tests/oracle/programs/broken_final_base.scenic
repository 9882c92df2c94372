#! id: broken_final_base
#! kind: error
#! tags: final property of a base
class C:
    position[final]: 3 @ 4
class D(C):
    position: 5 @ 5
ego = new D
