#! id: py_choice_index
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
l = Uniform([1, 2, 3], [4, 5, 6])
i = DiscreteRange(0, 2)
param a = l[i]
