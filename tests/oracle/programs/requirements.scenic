#! id: requirements
#! kind: static
#! tags: hard requirements on several draws
#! n: 500
x = Range(0, 10)
y = Range(0, 10)
ego = new Object at x @ y
b = new Object at y @ (x + 3)
require x + y < 12
require (distance from ego to b) > 4
require x > 2 or y > 2
