function values = patch_values(planes, margin)
% Values at the centres of the 24 patches of 32 x 32 pixels (one row per patch, one column per plane), counted down the
% columns of the chart. `margin` is the border around the chart as [rows columns].
[col, row] = meshgrid(16:32:192, 16:32:128);
at = sub2ind([rows(planes) columns(planes)], row(:) + margin(1), col(:) + margin(2));
planes = reshape(planes, rows(planes) * columns(planes), []);
values = double(planes(at, :));
end
