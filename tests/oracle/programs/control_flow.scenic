#! id: control_flow
#! kind: static
#! tags: if, for, while, try-less Python on constants
#! n: 20
count = 0
spots = {}
for i in range(5):
    if i % 2 == 0:
        continue
    spots[i] = i * 3
    count += 1
while count < 4:
    count += 1
else:
    count += 10
ego = new Object at count @ spots[3]
param known = 3 in spots, both = [k for k in sorted(spots)][0], words = 'a' + 'b' * 3
