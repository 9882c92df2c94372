#! id: resampled_parts
#! kind: static
#! n: 1200
base = Normal(5, 2)
word = Uniform("a", "b", "c")
count = DiscreteRange(2, 4)
ego = new Object at base @ resample(base), with requireVisible False
param first = word, second = resample(word)
param sum = count + 10 * resample(count)
