function score = color_error(xyz)
% Colour differences of the 24 patches from the chart under D65. Both whites (patch 4) get the same Y. Differences refer
% both sides to the white of the ideal chart, or, in `ownwhite`, each side to its own; `lab` refers to the measured white.
ideal = macbethIdealColor('d65', 'xyz');
white = ideal(4, :);
xyz = xyz / xyz(4, 2) * white(2);
score = struct('xyz', xyz, 'lab', ieXYZ2LAB(xyz, xyz(4, :)));
for formula = {'2000', '1994', '1976'}
  score.(['dE' formula{1}]) = deltaEab(xyz, ideal, white, formula{1});
end
score.dE1976_ownwhite = deltaEab(xyz, ideal, {xyz(4, :), white}, '1976');
for key = {'dE2000', 'dE1994', 'dE1976', 'dE1976_ownwhite'}
  score.(['mean_' key{1}]) = mean(score.(key{1}));
end
end
