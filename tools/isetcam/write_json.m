function write_json(out, name, value)
file = fopen(fullfile(out, name), 'w');
fputs(file, [jsonencode(in_double(value)) "\n"]);
fclose(file);
end

function value = in_double(value)
% Octave writes no single precision as JSON.
if isstruct(value)
  value = arrayfun(@(s) structfun(@in_double, s, 'UniformOutput', false), value);
elseif iscell(value)
  value = cellfun(@in_double, value, 'UniformOutput', false);
elseif ~ischar(value)
  value = double(value);
end
end
