function write_csv(out, name, matrix)
% One row per line, with the digits that single precision needs at least.
file = fopen(fullfile(out, name), 'w');
format = [strjoin(repmat({'%.10g'}, 1, columns(matrix)), ',') '\n'];
fprintf(file, format, double(matrix).');
fclose(file);
end
