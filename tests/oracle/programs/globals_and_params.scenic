#! id: globals_and_params
#! kind: static
#! tags: global statements, parameters read back
#! n: 100
param speed = Range(1, 2), name = 'storm'
total = 0
def add(n):
    global total
    total += n
for n in (1, 2, 3):
    add(n)
ego = new Object at total @ globalParameters.speed
param twice = globalParameters.speed * 2
