function value = read_json(data, name)
value = jsondecode(fileread(fullfile(data, name)));
end
