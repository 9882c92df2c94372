#! id: exceptions_and_asserts
#! kind: static
#! tags: try, except, finally, assert
#! n: 20
value = 1
try:
    value = {}['none']
except KeyError as missing:
    value += 5
finally:
    value += 10
assert value == 16
ego = new Object at value @ 0
