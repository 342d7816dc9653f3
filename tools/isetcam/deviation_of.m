function deviation = deviation_of(draws)
% Standard deviation of every number over a cell array of draws: arrays of one size, or structs of such arrays.
if isstruct(draws{1})
  deviation = struct();
  for key = fieldnames(draws{1}).'
    each = cellfun(@(draw) draw.(key{1}), draws, 'UniformOutput', false);
    deviation.(key{1}) = deviation_of(each);
  end
else
  each = cellfun(@(draw) double(draw), draws, 'UniformOutput', false);
  dimension = ndims(each{1}) + 1;
  deviation = std(cat(dimension, each{:}), 0, dimension);
end
end
