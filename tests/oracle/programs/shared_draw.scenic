#! id: shared_draw
#! kind: static
#! tags: draw used twice
#! n: 400
shift = Range(2, 6)
ego = new Object at shift @ -shift, with requireVisible False
twin = new Object at (shift + 4) @ (2 * shift), with requireVisible False
param double = shift * 2, inverse = 1 / shift, power = shift ** 2
